//! Pictures of any shape and size, and views anywhere in a larger buffer.

use bevy::math::UVec2;
use bevy_lean_deferred::effects::ambient_occlusion::LeanScreenSpaceAmbientOcclusion;

use crate::views::{
    ORTHOGRAPHIC, PERSPECTIVE, corner, crop, difference, kinds, kinds_and_filters, plane, run, wall,
};
use kit::{
    occlusion::{camera::Projection, depth_buffer::pixels, errors::Errors},
    occlusion_gpu::{DepthImage, OcclusionGpu},
};

/// Wider and taller pictures have the same occlusion in their common middle.
#[test]
fn the_aspect_ratio_does_not_matter() {
    const MIDDLE: UVec2 = UVec2::splat(272);
    let gpu = OcclusionGpu::new();
    let found = [UVec2::new(480, 272), MIDDLE, UVec2::new(272, 480)].map(|size| {
        let Projection::Perspective { fov_y, near } = PERSPECTIVE else {
            panic!("it is one");
        };
        let half_height = (0.5 * fov_y).tan() * f64::from(size.y) / f64::from(MIDDLE.y);
        let projection = Projection::Perspective {
            fov_y: 2.0 * half_height.atan(),
            near,
        };
        let seen = wall().with_size(size).with_projection(projection).seen();
        let occlusion = run(
            &gpu,
            &LeanScreenSpaceAmbientOcclusion::default(),
            &seen.image,
        )
        .filtered;
        let part = |picture: &[f32]| crop(picture, size.x, (size - MIDDLE) / 2, MIDDLE);
        let truth = crop(&seen.truth, size.x, (size - MIDDLE) / 2, MIDDLE);
        (part(&occlusion), truth, seen.mask)
    });
    let mask = &found[1].2;
    let square = Errors::measure(&found[1].0, &found[1].1, mask);
    for ((occlusion, truth, _), shape) in found.iter().zip(["16:9", "1:1", "9:16"]) {
        let errors = Errors::measure(occlusion, truth, mask);
        println!("{shape}: {errors}");
        assert!((errors.rmse - square.rmse).abs() < 0.001 * square.rmse);
        let reference: Vec<_> = found[1].0.iter().copied().map(Some).collect();
        let errors = Errors::measure(occlusion, &reference, mask);
        println!("{shape} beside 1:1: RMSE {:.1e}", errors.rmse);
        assert!(errors.rmse < 1e-4);
    }
}

/// A view's depths in a larger buffer. Around them are invalid depths, and depths that would occlude neighbouring pixels.
fn in_buffer(depth: &[f32], size: UVec2, origin: UVec2, buffer_size: UVec2) -> Vec<f32> {
    const HOSTILE: [f32; 7] = [f32::NAN, 1.0, 0.0, f32::INFINITY, 0.5, -1.0, 1e-40];
    let value = |pixel: UVec2| {
        let nearest = (pixel.max(origin) - origin).min(size - 1);
        let depth = depth[(nearest.y * size.x + nearest.x) as usize];
        if nearest + origin == pixel {
            depth
        } else if (pixel.x + pixel.y).is_multiple_of(3) {
            HOSTILE[(pixel.x % 7) as usize]
        } else {
            (1.0 + 0.02 * (pixel.x % 5) as f32) * depth
        }
    };
    pixels(buffer_size).map(|(pixel, _)| value(pixel)).collect()
}

#[test]
fn a_view_is_alone_in_its_buffer() {
    let gpu = OcclusionGpu::new();
    let (size, origin) = (UVec2::new(240, 135), UVec2::new(37, 21));
    let buffer_size = UVec2::new(331, 200);
    for view in [wall(), corner().with_projection(ORTHOGRAPHIC)] {
        let seen = view.with_size(size).seen_within(0.0);
        let depth = in_buffer(&seen.image.depth, size, origin, buffer_size);
        let mut image = DepthImage::new(depth, buffer_size, seen.image.clip_from_view);
        image.viewport = (origin, size);
        for settings in kinds_and_filters() {
            let alone = run(&gpu, &settings, &seen.image);
            let within = run(&gpu, &settings, &image);
            let errors = difference(&within.filtered, &alone.filtered);
            println!(
                "{:?}, {:?}: {errors}",
                settings.resolution, settings.advanced
            );
            assert!(alone.gathered == within.gathered && alone.filtered == within.filtered);
        }
    }
}

#[test]
fn sizes_may_be_odd_and_small() {
    let gpu = OcclusionGpu::new();
    for (x, y) in [(1, 1), (2, 2), (3, 5), (7, 1), (1, 7), (64, 3), (317, 211)] {
        let size = UVec2::new(x, y);
        for settings in kinds() {
            let flat = plane(1.2, 2.0).with_size(size).seen_within(0.0);
            let on_plane = run(&gpu, &settings, &flat.image).filtered;
            let largest = on_plane.iter().copied().fold(0.0, f32::max);
            assert_eq!(largest, 0.0, "{size}, {settings:?}");

            let seen = wall().with_size(size).seen_within(0.0);
            let mean = run(&gpu, &settings, &seen.image)
                .filtered
                .iter()
                .sum::<f32>()
                / (x * y) as f32;
            println!(
                "{size}, {:?}, {:?}: mean {mean:.4}",
                settings.advanced.kernel, settings.resolution
            );
        }
    }
    let seen = wall().with_size(UVec2::new(317, 211)).seen();
    let errors = seen.errors(
        &run(
            &gpu,
            &LeanScreenSpaceAmbientOcclusion::default(),
            &seen.image,
        )
        .filtered,
    );
    println!("317 × 211: {errors}");
    assert!(errors.rmse <= 0.03);
}
