//! Surfaces close to the camera, where distant samples are from lattices of pixels.

use bevy::math::UVec2;
use bevy_lean_deferred::{
    effects::ambient_occlusion::LeanScreenSpaceAmbientOcclusion,
    view::{LeanQuality, LeanResolution},
};
use kit::{
    occlusion::{depth_buffer::pixels, errors::Errors},
    occlusion_gpu::{DepthImage, OcclusionGpu, Path},
    skipped::occlusion_by_compute,
};

use crate::views::{RADIUS, groove, plane, run_by, sphere, wall};

/// All presets of the horizon-based kernel, and half resolution.
fn presets() -> impl Iterator<Item = (String, LeanScreenSpaceAmbientOcclusion)> {
    let default = LeanScreenSpaceAmbientOcclusion::default();
    let presets = LeanQuality::ALL.map(|quality| {
        let settings = LeanScreenSpaceAmbientOcclusion { quality, ..default };
        (quality.to_string(), settings)
    });
    let half = LeanScreenSpaceAmbientOcclusion {
        resolution: LeanResolution::Half,
        ..default
    };
    presets.into_iter().chain([("Medium, half".into(), half)])
}

/// Occlusion as it is stored, and filtered.
fn computed(
    gpu: &OcclusionGpu,
    settings: &LeanScreenSpaceAmbientOcclusion,
    image: &DepthImage,
) -> [Vec<f32>; 2] {
    let occlusion = run_by(Path::Compute, gpu, settings, image);
    [occlusion.gathered, occlusion.filtered]
}

/// The same view has the same errors with a radius of 30 to 60 pixels and with one of 120 to 240.
#[test]
fn closed_forms_hold_near_the_camera() {
    let Some(gpu) = occlusion_by_compute() else {
        return;
    };
    for view in [wall, groove, sphere] {
        let errors = |height: u32| {
            let view = view().with_size(UVec2::new(height, height));
            let seen = view.seen();
            let errors = presets().map(|(name, settings)| {
                let [_, filtered] = computed(&gpu, &settings, &seen.image);
                (name, seen.errors(&filtered))
            });
            errors.collect::<Vec<_>>()
        };
        for ((name, far), (_, near)) in errors(270).into_iter().zip(errors(1080)) {
            println!(
                "{}, {name}: {near}; four times as small: {far}",
                view().name
            );
            assert!(near.rmse <= 1.03 * far.rmse && near.p99 <= 1.05 * far.p99);
            assert!(near.bias <= 0.001);
        }
    }
}

/// Samples of lattices are exact depths of other pixels, at exact distances.
#[test]
fn planes_near_the_camera_are_not_occluded() {
    let Some(gpu) = occlusion_by_compute() else {
        return;
    };
    for tilt in [0.0, 45.0, 80.0, 88.0] {
        // Odd sides have lattices of different sizes.
        let view = plane(f64::to_radians(tilt), 1.0).with_size(UVec2::new(483, 961));
        let seen = view.seen_within(0.0);
        for (name, mut settings) in presets() {
            settings.radius = RADIUS as f32;
            let [gathered, _] = computed(&gpu, &settings, &seen.image);
            let largest = gathered.into_iter().fold(0.0, f32::max);
            assert_eq!(largest, 0.0, "{tilt}°, {name}");
        }
    }
}

/// A part of the depth texture has the occlusion that it has alone.
#[test]
fn lattices_are_those_of_the_viewport() {
    let Some(gpu) = occlusion_by_compute() else {
        return;
    };
    let size = UVec2::new(301, 482);
    let seen = wall().with_size(size).seen_within(0.0);
    let (origin, whole) = (UVec2::new(7, 5), UVec2::new(320, 500));
    let mut depths = vec![0.5; whole.element_product() as usize];
    for ((pixel, _), depth) in pixels(size).zip(&seen.image.depth) {
        let place = origin + pixel;
        depths[(place.x + place.y * whole.x) as usize] = *depth;
    }
    let part = DepthImage {
        viewport: (origin, size),
        ..DepthImage::new(depths, whole, seen.image.clip_from_view)
    };
    for (name, settings) in presets() {
        let [alone, _] = computed(&gpu, &settings, &seen.image);
        let [of_part, _] = computed(&gpu, &settings, &part);
        assert!(alone == of_part, "{name}");
    }
}

/// Side of the pictures of poles, whose radius is a quarter of it: 160 pixels.
const SIDE: u32 = 640;

/// A wall with a pole one pixel wide `gap` metres in front of it, in a column or a row.
fn pole(gap: f64, is_pole: impl Fn(UVec2) -> bool) -> DepthImage {
    let size = UVec2::splat(SIDE);
    let camera = plane(0.0, 2.0).with_size(size).camera;
    let depths = pixels(size).map(|(pixel, _)| {
        let nearer = if is_pole(pixel) { gap } else { 0.0 };
        camera.depth(2.0 - nearer) as f32
    });
    DepthImage::new(depths.collect(), size, camera.clip_from_view().as_mat4())
}

/// Columns (axis 0) and rows, one of each place in the lattices.
const AXES: [usize; 2] = [0, 1];
const PLACES: [u32; 4] = [320, 321, 322, 323];

#[test]
fn thin_poles_near_the_camera_have_no_halo() {
    let Some(gpu) = occlusion_by_compute() else {
        return;
    };
    for (axis, place) in AXES
        .into_iter()
        .flat_map(|axis| PLACES.map(|place| (axis, place)))
    {
        let image = pole(1.1 * RADIUS, |pixel| pixel[axis] == place);
        for (name, settings) in presets() {
            let [_, filtered] = computed(&gpu, &settings, &image);
            let largest = filtered.into_iter().fold(0.0, f32::max);
            assert_eq!(largest, 0.0, "{name}, along axis {axis} at {place}");
        }
    }
}

/// A pole one pixel wide occludes as much of the wall behind it as if all samples were dense, 20 pixels from it and more too. With one
/// slice a place's only pixels may sample along the pole: then the mean of all places counts.
#[test]
fn thin_poles_near_the_camera_are_not_lost() {
    let Some(gpu) = occlusion_by_compute() else {
        return;
    };
    for ((name, settings), axis) in presets().flat_map(|of| AXES.map(|axis| (of.clone(), axis))) {
        let of_places = PLACES.map(|place| {
            let image = pole(0.3 * RADIUS, |pixel| pixel[axis] == place);
            let is_beside = |pixel: UVec2| (20..80).contains(&pixel[axis].abs_diff(place));
            let mask: Vec<bool> = pixels(image.size)
                .map(|(pixel, _)| is_beside(pixel))
                .collect();
            let none = vec![Some(0.0); mask.len()];
            [Path::Compute, Path::Raster].map(|path| {
                let occlusion = run_by(path, &gpu, &settings, &image).filtered;
                Errors::measure(&occlusion, &none, &mask).mean
            })
        });
        println!("{name}, axis {axis}: with lattices, and dense: {of_places:.4?}");
        let [lattices, dense] = [0, 1].map(|i| of_places.iter().map(|of| of[i]).sum::<f64>());
        assert!((0.85..1.15).contains(&(lattices / dense)));
        let (slices, _) = settings.samples();
        for [lattices, dense] in of_places {
            assert!(slices == 1 || lattices >= 0.6 * dense);
        }
    }
}
