//! Marches of many pixels, whose samples far from the pixel are read at corners of cells: their depths, errors and cache lines.

use std::{collections::BTreeSet, f32::consts::PI, f64::consts::FRAC_PI_8};

use bevy::math::{IVec2, UVec2, Vec2};
use bevy_lean_deferred::{
    effects::ambient_occlusion::{
        LeanScreenSpaceAmbientOcclusion,
        far_depths::{CELL_SIDE, FAR_RADIUS, cells, near_steps},
    },
    view::{LeanQuality, LeanResolution},
};
use kit::{
    occlusion::{depth_buffer::pixels, errors::Errors, geometry::Geometry},
    occlusion_gpu::{DepthImage, OcclusionGpu, Path},
};

use crate::views::{RADIUS, TALL, View, difference, plane, run, run_by, wall};

/// The device's gather, if it is the one that reads depths at corners of cells.
fn compute() -> Option<OcclusionGpu> {
    let gpu = OcclusionGpu::new();
    if gpu.path() == Path::Compute {
        return Some(gpu);
    }
    println!("skipped: occlusion by compute: the device has no storage textures of its format");
    None
}

/// Every fourth pixel of every fourth row, to the bit, in views of any size and place, of any depth.
#[test]
fn far_depths_are_those_of_their_pixels() {
    const HOSTILE: [f32; 7] = [f32::NAN, 1.0, 0.0, f32::INFINITY, 0.5, -1.0, 1e-40];
    let Some(gpu) = compute() else {
        return;
    };
    let buffer_size = UVec2::new(333, 411);
    let seen = wall().with_size(buffer_size).seen();
    let depth = seen.image.depth.iter().enumerate();
    let depth = depth.map(|(i, depth)| match i % 5 {
        0 => HOSTILE[i % 7],
        _ => *depth,
    });
    let mut image = DepthImage::new(depth.collect(), buffer_size, seen.image.clip_from_view);
    let held = gpu.held_depth(&image);
    for (origin, size) in [
        (UVec2::ZERO, buffer_size),
        (UVec2::new(3, 1), UVec2::new(317, 211)),
        (UVec2::new(9, 2), UVec2::new(1, 200)),
    ] {
        image.viewport = (origin, size);
        let settings = LeanScreenSpaceAmbientOcclusion::default();
        let found = run(&gpu, &settings, &image)
            .far_depths
            .expect("the radius may be far");
        let expected: Vec<u32> = pixels(cells(size))
            .map(|(cell, _)| origin + CELL_SIDE * cell)
            .map(|p| held[(p.y * buffer_size.x + p.x) as usize].to_bits())
            .collect();
        let found: Vec<u32> = found.into_iter().map(f32::to_bits).collect();
        assert!(found == expected, "{size} at {origin}");
    }
}

/// No far depths are made for a view whose radius cannot be far.
#[test]
fn small_views_have_no_far_depths() {
    let gpu = OcclusionGpu::new();
    for (x, y) in [(1, 1), (7, 1), (300, 180)] {
        let seen = wall().with_size(UVec2::new(x, y)).seen_within(0.0);
        let settings = LeanScreenSpaceAmbientOcclusion::default();
        assert!(run(&gpu, &settings, &seen.image).far_depths.is_none());
    }
}

/// A view whose radius covers about `radius` pixels, with a margin for its march.
fn sized(view: impl Fn(f64) -> View, radius: u32) -> View {
    let height = 4.2 * f64::from(radius);
    let distance = 0.5 * height / FRAC_PI_8.tan() * RADIUS / f64::from(radius);
    view(distance).with_size(UVec2::new((2.4 * f64::from(radius)) as u32, height as u32))
}

fn wall_from(distance: f64) -> View {
    View::new(
        "wall",
        Geometry::Wall { height: TALL },
        [0.15 + 0.6 * distance, 0.7 * distance, 0.39 * distance],
        [0.15, 0.0, 0.0],
    )
}

fn ball_from(distance: f64) -> View {
    let ball = Geometry::Sphere {
        sphere_radius: 0.2,
        height: 0.25,
    };
    View::new(
        "ball",
        ball,
        [0.0, 0.7 * distance, 0.7 * distance],
        [0.0; 3],
    )
}

/// Errors against closed forms are those of the raster pass, which samples the same directions and distances at pixels.
fn check_errors(radius: u32, qualities: &[LeanQuality]) {
    let Some(gpu) = compute() else {
        return;
    };
    for view in [sized(wall_from, radius), sized(ball_from, radius)] {
        let seen = view.seen();
        for quality in qualities {
            for resolution in LeanResolution::ALL {
                let settings = LeanScreenSpaceAmbientOcclusion {
                    quality: *quality,
                    resolution,
                    ..LeanScreenSpaceAmbientOcclusion::default()
                };
                let [far, near] = [Path::Compute, Path::Raster]
                    .map(|path| run_by(path, &gpu, &settings, &seen.image).filtered);
                let [of_far, of_near] = [&far, &near].map(|occlusion| seen.errors(occlusion));
                println!(
                    "{}, {radius} pixels, {quality:?}, {resolution:?}: {of_far}; at pixels {of_near}; between them {}",
                    view.name,
                    difference(&far, &near),
                );
                assert!(far != near);
                assert!(of_far.rmse <= 1.08 * of_near.rmse);
                assert!((of_far.bias - of_near.bias).abs() <= 0.001);
            }
        }
    }
}

#[test]
fn far_marches_are_as_exact_as_at_pixels() {
    check_errors(115, &[LeanQuality::Medium]);
}

#[test]
#[ignore = "nightly: other radii and qualities"]
fn far_marches_of_any_radius_are_as_exact_as_at_pixels() {
    for radius in [58, 115, 230, 461, 922] {
        check_errors(radius, &LeanQuality::ALL);
    }
}

/// Planes stay open in far marches, at any tilt and quality.
#[test]
fn far_marches_leave_planes_open() {
    let gpu = OcclusionGpu::new();
    for tilt in [0.0, 45.0, 80.0, 88.0] {
        let view = plane(f64::to_radians(tilt), 2.0).with_size(UVec2::new(250, 420));
        let seen = view.seen_within(0.0);
        let on_surface: Vec<bool> = seen.truth.iter().map(Option::is_some).collect();
        for quality in LeanQuality::ALL {
            let settings = LeanScreenSpaceAmbientOcclusion {
                quality,
                ..LeanScreenSpaceAmbientOcclusion::default()
            };
            let occlusion = run(&gpu, &settings, &seen.image).filtered;
            let errors = Errors::measure(&occlusion, &seen.truth, &on_surface);
            assert_eq!(errors.largest, 0.0, "{tilt} degrees, {quality:?}");
        }
    }
}

/// Texels along a side of a square of 64 bytes.
const LINE_SIDE: i32 = 4;

/// Texel that a sample is read from, and the texture: 0 is depth, 1 the depths at corners of cells.
type Texel = (u32, IVec2);

fn rounded(place: Vec2) -> IVec2 {
    place.map(f32::round_ties_even).as_ivec2()
}

/// Texels of depth that a pixel on a plane that faces the viewer samples, by its twin of the march in `hbao.wgsl`.
fn sampled(pixel: IVec2, radius: f32, (slices, steps): (u32, u32), is_far: bool) -> Vec<Texel> {
    let [place, quad] = [pixel & 1, (pixel >> 1) & 1];
    let phase = if place.y == 0 {
        3 * place.x
    } else {
        2 - place.x
    };
    let block = quad.x + 2 * quad.y;
    let mut texels = Vec::new();
    for slice in 0..slices {
        let angle = PI / slices as f32 * (slice as f32 + 0.25 * phase as f32);
        let direction = Vec2::from_angle(angle) * Vec2::new(1.0, -1.0);
        let length = radius * direction.abs().max_element();
        let direction = direction / direction.abs().max_element();
        let part = 0.5 / steps as f32;
        let [quadratic, linear] = [length * part * 2.0 * part, length * part];
        let offset = (0.125 + 0.25 * (phase ^ block) as f32 + 0.618 * slice as f32).fract();
        for i in 0..steps {
            let x = i as f32;
            let at_first = ((quadratic * offset + linear) * offset).max(1.0);
            let growth = (2.0 * quadratic * offset + linear).max(1.0);
            let distance = at_first + x * growth + x * x * quadratic;
            for side in [1.0, -1.0] {
                let end = pixel.as_vec2() + side * distance * direction;
                let is_at_cell = is_far && radius > FAR_RADIUS && i >= near_steps(steps);
                texels.push(if is_at_cell {
                    (1, rounded(end / CELL_SIDE as f32))
                } else {
                    (0, rounded(end))
                });
            }
        }
    }
    texels
}

/// Cache lines that a workgroup touches: those of the depths of its pixels, and of all samples.
fn lines(radius: f32, samples: (u32, u32), is_far: bool) -> usize {
    const SIDE: i32 = 16;
    let corner = IVec2::splat(4096);
    let mut lines = BTreeSet::new();
    for (offset, _) in pixels(UVec2::splat(SIDE as u32 + 4)) {
        let pixel = corner + offset.as_ivec2() - 2;
        lines.insert((0, (pixel / LINE_SIDE).to_array()));
    }
    for (offset, _) in pixels(UVec2::splat(SIDE as u32)) {
        for (texture, texel) in sampled(corner + offset.as_ivec2(), radius, samples, is_far) {
            lines.insert((texture, (texel / LINE_SIDE).to_array()));
        }
    }
    lines.len()
}

/// At any radius from 58 pixels on, a workgroup touches at most half as many cache lines as with samples at pixels.
#[test]
fn far_marches_touch_few_cache_lines() {
    println!("| radius | quality | at pixels | with far depths |");
    for quality in LeanQuality::ALL {
        let settings = LeanScreenSpaceAmbientOcclusion {
            quality,
            ..LeanScreenSpaceAmbientOcclusion::default()
        };
        for radius in [58, 115, 230, 461, 922] {
            let [near, far] =
                [false, true].map(|is_far| lines(radius as f32, settings.samples(), is_far));
            println!("| {radius} | {quality:?} | {near} | {far} |");
            assert!(2 * far <= near, "{radius}, {quality:?}: {far} of {near}");
        }
    }
}
