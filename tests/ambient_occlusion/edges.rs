//! Surfaces beside outlines that must stay unoccluded.

use bevy::math::UVec2;
use bevy_lean_deferred::{
    effects::ambient_occlusion::{
        LeanScreenSpaceAmbientOcclusion, LeanScreenSpaceAmbientOcclusionAdvanced as Advanced,
        OcclusionFilter,
    },
    view::LeanResolution,
};

use crate::views::{RADIUS, SIZE, Seen, View, corner, kinds, kinds_and_filters, run};
use kit::{
    occlusion::{depth_buffer::pixels, errors::Errors, geometry::Geometry, solids::Hit},
    occlusion_gpu::{DepthImage, OcclusionGpu},
};

fn named(settings: &LeanScreenSpaceAmbientOcclusion) -> String {
    let resolution = settings.resolution;
    let Advanced {
        kernel,
        filter,
        edge_aware,
        ..
    } = settings.advanced;
    format!("{kernel:?}, {resolution:?}, {filter:?}, edge-aware {edge_aware}")
}

/// Largest occlusion of a part of a view.
fn largest(seen: &Seen, occlusion: &[f32], part: impl Fn(Option<&Hit>) -> bool) -> f32 {
    let pixels = seen.buffer.hits.iter().zip(occlusion);
    pixels
        .filter(|(hit, _)| part(hit.as_ref()))
        .map(|(_, x)| *x)
        .fold(0.0, f32::max)
}

fn pole(thickness: f64, gap: f64) -> View {
    let pole = Geometry::Pole { thickness, gap };
    View::new("pole", pole, [0.4, 0.5, 4.0], [0.1, 0.0, 0.0])
}

/// Neither the pole nor the wall behind it is occluded: they are further apart than the radius.
#[test]
fn thin_poles_have_no_halo() {
    let gpu = OcclusionGpu::new();
    // From one to nine pixels wide.
    for thickness in [0.012, 0.03, 0.1] {
        for gap in [0.7, 1.0, 10.0] {
            let seen = pole(thickness, gap).seen();
            let halo_of = |settings: LeanScreenSpaceAmbientOcclusion| {
                let occlusion = run(&gpu, &settings, &seen.image).filtered;
                largest(&seen, &occlusion, |hit| hit.is_some())
            };
            let [wide, narrow] = [OcclusionFilter::Wide, OcclusionFilter::Narrow].map(|filter| {
                kinds_and_filters()
                    .filter(|settings| settings.advanced.filter == filter)
                    .map(halo_of)
                    .fold(0.0, f32::max)
            });
            println!(
                "pole of {thickness} m, {gap} m before a wall: {narrow}, {wide} with wide filters"
            );
            assert_eq!(narrow, 0.0);
            // Of a wide filter's many directions, one runs along a pole one pixel wide and detects that it is not quite straight.
            assert!(wide <= 0.001);
        }
    }
}

/// Within the radius a pole counts as infinitely deep, as in the integral; a finite `thickness` narrows its halo.
#[test]
fn thickness_narrows_the_halo_of_near_poles() {
    let gpu = OcclusionGpu::new();
    let seen = pole(0.05, 0.3).seen();
    let is_on_wall = |hit: &Option<Hit>| hit.as_ref().is_some_and(|hit| hit.point.z < -0.2);
    let on_wall: Vec<bool> = seen.buffer.hits.iter().map(is_on_wall).collect();
    let none = vec![Some(0.0); on_wall.len()];
    let integral = Errors::measure_sparse(&seen.integral(4), &none, &on_wall).mean;
    let mut thicker = integral;
    for thickness in [None, Some(1.0), Some(0.3), Some(0.1), Some(0.03), Some(0.0)] {
        let settings = LeanScreenSpaceAmbientOcclusion {
            thickness,
            ..LeanScreenSpaceAmbientOcclusion::default()
        };
        let occlusion = run(&gpu, &settings, &seen.image).filtered;
        let mean = Errors::measure(&occlusion, &none, &on_wall).mean;
        println!("thickness {thickness:?}: mean {mean:.4} on the wall, integral {integral:.4}");
        assert!(mean < thicker);
        thicker = mean;
    }
    assert!(thicker <= 0.04 * integral);
}

#[test]
fn the_sky_is_free_and_takes_nothing_away() {
    let gpu = OcclusionGpu::new();
    let sphere = Geometry::Sphere {
        sphere_radius: 0.5,
        height: 0.6,
    };
    let wall = Geometry::Wall { height: 0.4 };
    // With bounds of the occlusion of open surfaces: for edge-aware filters at full resolution, wide ones, and half resolution.
    for (view, of_full, of_wide, of_half) in [
        (
            View::new("sphere", sphere, [0.0, 0.5, 3.0], [0.0, 0.7, 0.0]),
            0.0065,
            0.027,
            0.022,
        ),
        (
            View::new("wall", wall, [1.5, 0.3, 2.0], [0.0, 0.35, 0.0]),
            0.0,
            // A tap two pixels away, seen from the side, lies on floor that is nearer to the wall.
            0.024,
            0.069,
        ),
    ] {
        let seen = view.seen();
        for settings in kinds_and_filters() {
            let occlusion = run(&gpu, &settings, &seen.image).filtered;
            let in_sky = largest(&seen, &occlusion, |hit| hit.is_none());
            let open = largest(&seen, &occlusion, |hit| {
                hit.is_some_and(|hit| view.scene.occlusion(hit, RADIUS) == Some(0.0))
            });
            println!(
                "{} before the sky, {}: {in_sky} in the sky, {open:.4} on what is open",
                view.name,
                named(&settings)
            );
            assert_eq!(in_sky, 0.0);
            let bound = match settings.resolution {
                LeanResolution::Full if settings.has_wide_pattern() => of_wide,
                LeanResolution::Full => of_full,
                LeanResolution::Half => of_half,
            };
            assert!(!settings.advanced.edge_aware || open <= bound);
        }
    }
}

/// Pixels with no other surface within four pixels, the reach of the half-resolution filter.
fn within_facets(seen: &Seen) -> Vec<bool> {
    let normals = seen.buffer.normals();
    let same = |a: UVec2, b: UVec2| {
        let [a, b] = [a, b].map(|pixel| normals[(pixel.y * SIZE.x + pixel.x) as usize]);
        a.zip(b).is_some_and(|(a, b)| a.dot(b) > 0.99999)
    };
    let is_within = |pixel: UVec2| {
        pixel.cmpge(UVec2::splat(4)).all()
            && (pixel + 4).cmplt(SIZE).all()
            && (0..81).all(|i| same(pixel, pixel + UVec2::new(i % 9, i / 9) - 4))
    };
    pixels(SIZE).map(|(pixel, _)| is_within(pixel)).collect()
}

/// Facets of convex meshes are exactly unoccluded. At some pixels on their edges the tangents belong to two facets, and no plane through
/// them has all of the mesh below it.
#[test]
fn facets_of_convex_meshes_do_not_show() {
    let gpu = OcclusionGpu::new();
    for facets in [6, 12, 32] {
        let cylinder = Geometry::FacetedCylinder {
            cylinder_radius: 0.5,
            facets,
        };
        for eye in [[0.0, 0.5, 2.0], [0.3, 2.0, 1.0], [0.2, 0.1, 0.8]] {
            let seen = View::new("cylinder", cylinder, eye, [0.0; 3]).seen();
            let inside = within_facets(&seen);
            let on_surface: Vec<bool> = seen.truth.iter().map(Option::is_some).collect();
            for settings in kinds() {
                let occlusion = run(&gpu, &settings, &seen.image).filtered;
                let band = Errors::measure(&occlusion, &seen.truth, &inside);
                let all = Errors::measure(&occlusion, &seen.truth, &on_surface);
                let dark = occlusion.iter().filter(|x| **x > 0.02).count();
                println!(
                    "{facets} facets from {eye:?}, {:?}, {:?}: {} within facets; on edges up to {:.3}, {dark} of {} \
                     pixels above 0.02, mean {:.1e}",
                    settings.advanced.kernel,
                    settings.resolution,
                    band.largest,
                    all.largest,
                    all.count,
                    all.mean
                );
                assert_eq!(band.largest, 0.0);
                // Facets foreshortened to two pixels do not fill the nine taps of a kernel.
                assert!(all.mean <= 2.5e-4 && dark <= all.count / 500 && all.largest < 0.48);
            }
        }
    }
}

/// A grid of wires one pixel wide, in even and odd columns and rows, far in front of a corner: little occlusion bleeds onto the wires or
/// between them.
#[test]
fn occlusion_hardly_bleeds_over_steps_of_one_pixel() {
    let gpu = OcclusionGpu::new();
    let seen = corner().seen();
    let is_wire = |i: usize| {
        let (x, y) = (i % SIZE.x as usize, i / SIZE.x as usize);
        x % 17 == 8 || y % 23 == 11
    };
    let depths = seen.image.depth.iter().enumerate();
    let before = seen.buffer.camera.depth(1.2) as f32;
    let depths = depths.map(|(i, depth)| if is_wire(i) { before } else { *depth });
    let image = DepthImage::new(depths.collect(), SIZE, seen.image.clip_from_view);
    let wires: Vec<bool> = (0..seen.mask.len()).map(is_wire).collect();
    let between: Vec<bool> = wires.iter().map(|wire| !wire).collect();
    for settings in kinds_and_filters() {
        let without = run(&gpu, &settings, &seen.image).filtered;
        let occlusion = run(&gpu, &settings, &image).filtered;
        let on_wires = Errors::measure(&occlusion, &vec![Some(0.0); wires.len()], &wires);
        let without: Vec<_> = without.into_iter().map(Some).collect();
        let between = Errors::measure(&occlusion, &without, &between);
        println!(
            "{}: on wires mean {:.4}, largest {:.4}; between them RMSE {:.4}, bias {:+.4}",
            named(&settings),
            on_wires.mean,
            on_wires.largest,
            between.rmse,
            between.bias
        );
        // Every wire has texels of its own, though only every other one along it.
        let (mean, rmse) = match (settings.advanced.edge_aware, settings.resolution) {
            (true, LeanResolution::Full) => (0.0, 0.03),
            (true, LeanResolution::Half) => (0.001, 0.027),
            (false, _) => (0.040, 0.037),
        };
        assert!(on_wires.mean <= mean && between.rmse <= rmse);
    }
}
