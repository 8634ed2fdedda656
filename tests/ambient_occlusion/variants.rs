//! Effects of filter, resolution and the kind of pass.

use bevy_lean_deferred::{
    effects::ambient_occlusion::{
        LeanScreenSpaceAmbientOcclusion, LeanScreenSpaceAmbientOcclusionAdvanced as Advanced,
        OcclusionFilter, OcclusionKernel,
    },
    view::{LeanQuality, LeanResolution},
};

use crate::views::{SIZE, View, corner, difference, run, run_by, wall};
use bevy::math::UVec2;
use kit::{
    occlusion::{depth_buffer::pixels, geometry::Geometry},
    occlusion_gpu::{OcclusionGpu, Path},
    skipped::occlusion_by_compute,
};

const DEFAULT: fn() -> LeanScreenSpaceAmbientOcclusion = LeanScreenSpaceAmbientOcclusion::default;

#[test]
fn raster_and_compute_passes_agree() {
    let Some(gpu) = occlusion_by_compute() else {
        return;
    };
    let seen = corner().seen();
    for kernel in [OcclusionKernel::Hbao, OcclusionKernel::Hdao] {
        for resolution in LeanResolution::ALL {
            let settings = LeanScreenSpaceAmbientOcclusion {
                resolution,
                advanced: Advanced {
                    kernel,
                    ..Advanced::default()
                },
                ..DEFAULT()
            };
            let [compute, raster] = [Path::Compute, Path::Raster]
                .map(|path| run_by(path, &gpu, &settings, &seen.image).gathered);
            let errors = difference(&raster, &compute);
            println!("{kernel:?}, {resolution:?}: {errors}");
            // Equal if both use the same arithmetic; otherwise a value may round to the other side.
            assert!(
                errors.rmse <= 1e-4 && errors.largest <= 1.0 / 255.0,
                "{errors}"
            );
        }
    }
}

/// A low wall from above, its top in front of the floor: the top is open, the floor beside its outline is not.
fn brink() -> View {
    let wall = Geometry::Wall { height: 0.3 };
    View::new("brink", wall, [-1.5, 2.5, 0.0], [0.0, 0.0, 0.0])
}

/// Largest difference between the means of two classes of pixels. Each class has a sample pattern of its own, and they repeat every `side`
/// pixels.
fn pattern(occlusion: &[f32], mask: &[bool], side: usize) -> f64 {
    let mut sums = vec![(0.0, 0u32); side * side];
    for (i, (x, _)) in occlusion
        .iter()
        .zip(mask)
        .enumerate()
        .filter(|(_, (_, mask))| **mask)
    {
        let (column, row) = (i % SIZE.x as usize, i / SIZE.x as usize);
        let (sum, count) = &mut sums[column % side + row % side * side];
        *sum += f64::from(*x);
        *count += 1;
    }
    let means = sums.into_iter().map(|(sum, count)| sum / f64::from(count));
    let (least, most) = means.fold((f64::MAX, f64::MIN), |(least, most), mean| {
        (mean.min(least), mean.max(most))
    });
    most - least
}

#[test]
fn filters_remove_the_pattern_and_keep_edges() {
    let gpu = OcclusionGpu::new();
    let (wall, brink) = (wall().seen(), brink().seen_within(0.0));
    let brink = brink.only(|hit| hit.point.x < 0.0);
    let shade = wall.shade(0.1);
    let raw = run(&gpu, &DEFAULT(), &wall.image).gathered;
    println!(
        "before the filter: pattern {:.4}, {}",
        pattern(&raw, &shade, 2),
        wall.errors(&raw)
    );
    use LeanResolution::{Full, Half};
    use OcclusionFilter::{Narrow, Wide};
    // With bounds of the remaining pattern, of the RMSE on the wall, and of the occlusion that bleeds onto the brink.
    for (resolution, filter, edge_aware, largest) in [
        (Full, Narrow, false, [3e-4, 0.029, 0.059]),
        (Full, Wide, false, [0.003, 0.022, 0.081]),
        (Full, Narrow, true, [0.0035, 0.029, 0.0]),
        (Full, Wide, true, [0.009, 0.023, 0.0]),
        (Half, Narrow, false, [8e-4, 0.029, 0.095]),
        (Half, Narrow, true, [0.0021, 0.031, 3e-4]),
    ] {
        let settings = LeanScreenSpaceAmbientOcclusion {
            resolution,
            advanced: Advanced {
                filter,
                edge_aware,
                ..Advanced::default()
            },
            ..DEFAULT()
        };
        // Narrow filters leave some of the differences between the steps of 4×4 pixels.
        let side = if filter == Wide { 4 } else { 2 };
        let occlusion = run(&gpu, &settings, &wall.image).filtered;
        let onto_brink = brink.errors(&run(&gpu, &settings, &brink.image).filtered);
        let found = [
            pattern(&occlusion, &shade, side),
            wall.errors(&occlusion).rmse,
            onto_brink.largest,
        ];
        println!(
            "{resolution:?}, {filter:?}, edge-aware {edge_aware}: pattern, RMSE, onto the brink {found:.5?}"
        );
        assert!(
            found
                .iter()
                .zip(largest)
                .all(|(found, largest)| *found <= largest),
            "{largest:?}"
        );
    }
}

/// Largest value of a picture around a pixel.
fn largest_around(picture: &[f32], pixel: UVec2) -> f32 {
    let around = (0..9).map(|i| (pixel + UVec2::new(i % 3, i / 3)).saturating_sub(UVec2::ONE));
    around
        .map(|pixel| pixel.min(SIZE - 1))
        .map(|pixel| picture[(pixel.x + SIZE.x * pixel.y) as usize])
        .fold(0.0, f32::max)
}

/// Treads one or two pixels high, on which few texels of half resolution lie, have no dark dots.
#[test]
fn half_resolution_has_no_dark_dots() {
    let gpu = OcclusionGpu::new();
    use LeanResolution::{Full, Half};
    const STAIRS: Geometry = Geometry::Staircase {
        tread: 0.25,
        riser: 0.15,
        steps: 6,
    };
    for eye in [[-6.0, 1.3, 2.0], [-5.0, 1.0, 3.0], [-8.0, 2.0, 1.0]] {
        let seen = View::new("stairs", STAIRS, eye, [0.7, 0.4, 0.0]).seen();
        let [ultra, half] = [(LeanQuality::Ultra, Full), (LeanQuality::Medium, Half)].map(
            |(quality, resolution)| {
                let settings = LeanScreenSpaceAmbientOcclusion {
                    quality,
                    resolution,
                    ..DEFAULT()
                };
                run(&gpu, &settings, &seen.image).filtered
            },
        );
        let dots = pixels(SIZE)
            .zip(&half)
            .filter(|((pixel, _), half)| **half > largest_around(&ultra, *pixel) + 0.2)
            .count();
        println!("from {eye:?}: {dots} dots");
        assert!(dots <= 5);
    }
}
