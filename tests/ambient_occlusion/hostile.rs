//! Invalid depths and settings.

use std::f32::consts::FRAC_PI_2;

use bevy::math::{Mat4, UVec2};
use bevy_lean_deferred::effects::ambient_occlusion::LeanScreenSpaceAmbientOcclusion;

use crate::views::{ORTHOGRAPHIC, SIZE, corner, difference, kinds, run, wall};
use kit::{
    occlusion_gpu::{DepthImage, OcclusionGpu},
    random::Random,
};

/// Depths that no rasteriser writes. (Where drivers clamp depths that shaders write, the clamped value is read.)
const DEPTHS: [f32; 9] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    -1.0,
    -1e-20,
    1e-40,
    1e-45,
    2.0,
    1e30,
];

/// A depth buffer with some hostile depths where there is occlusion to spoil, and a mask of these.
fn sprinkled(depth: &[f32], occlusion: &[f32]) -> (Vec<f32>, Vec<bool>) {
    let mut random = Random::new(7);
    let (mut depth, mut bad) = (depth.to_vec(), vec![false; depth.len()]);
    for value in DEPTHS.repeat(2) {
        let i = loop {
            let i = random.below(depth.len());
            if occlusion[i] > 0.05 {
                break i;
            }
        };
        (depth[i], bad[i]) = (value, true);
    }
    (depth, bad)
}

/// Pixels without a bad depth within `reach` pixels along both axes.
fn far_from(bad: &[bool], reach: i32) -> Vec<bool> {
    let size = SIZE.as_ivec2();
    let mut far = vec![true; bad.len()];
    for i in (0..bad.len()).filter(|i| bad[*i]) {
        let (x, y) = (i as i32 % size.x, i as i32 / size.x);
        for y in (y - reach).max(0)..(y + reach + 1).min(size.y) {
            let row = (y * size.x) as usize;
            let from = row + (x - reach).max(0) as usize;
            let to = row + (x + reach + 1).min(size.x) as usize;
            far[from..to].fill(false);
        }
    }
    far
}

#[test]
fn bad_depths_spoil_nothing_further_away_than_the_radius() {
    let gpu = OcclusionGpu::new();
    for view in [wall(), corner().with_projection(ORTHOGRAPHIC)] {
        let seen = view.seen_within(0.0);
        let occlusion = run(
            &gpu,
            &LeanScreenSpaceAmbientOcclusion::default(),
            &seen.image,
        )
        .filtered;
        let (depth, bad) = sprinkled(&seen.image.depth, &occlusion);
        let image = DepthImage::new(depth, SIZE, seen.image.clip_from_view);
        let held = gpu.held_depth(&image);
        let held: Vec<f32> = (0..bad.len())
            .filter(|i| bad[*i])
            .map(|i| held[i])
            .collect();
        println!("the depth buffer holds {held:?}");
        for settings in kinds() {
            // 0.1 m is at most 20 pixels in these views; the filter and its depths reach 6 further.
            let settings = LeanScreenSpaceAmbientOcclusion {
                radius: 0.1,
                ..settings
            };
            let far = far_from(&bad, 26);
            let without = run(&gpu, &settings, &seen.image).filtered;
            let with = run(&gpu, &settings, &image).filtered;
            let compared = far.iter().filter(|far| **far).count();
            let changed = (0..with.len()).filter(|i| with[*i] != without[*i]).count();
            let changed_far = (0..with.len())
                .filter(|i| far[*i] && with[*i].to_bits() != without[*i].to_bits())
                .count();
            println!(
                "{}, {:?}, {:?}: {changed} pixels changed, {changed_far} of {compared} far ones",
                view.name, settings.advanced.kernel, settings.resolution
            );
            assert!(changed >= bad.len().min(18) && compared > 60_000);
            assert_eq!(changed_far, 0);
        }
    }
}

/// For any depths every output is from 0 to 1, which `run` checks; uniform depths are unoccluded.
#[test]
fn depths_may_be_anything() {
    let gpu = OcclusionGpu::new();
    let seen = corner().with_size(UVec2::new(240, 135)).seen_within(0.0);
    let matrices = [
        seen.image.clip_from_view,
        2.0 * seen.image.clip_from_view,
        Mat4::orthographic_rh(-2.0, 2.0, -1.0, 1.0, 10.0, 0.0),
    ];
    let mut random = Random::new(8);
    let pixels = seen.image.depth.len();
    let contents: [(&str, Vec<f32>); 5] = [
        ("sky", vec![0.0; pixels]),
        ("not a number", vec![f32::NAN; pixels]),
        ("all at the camera", vec![1.0; pixels]),
        (
            "any bits",
            (0..pixels).map(|_| f32::from_bits(random.bits())).collect(),
        ),
        ("noise", (0..pixels).map(|_| random.unit()).collect()),
    ];
    for (name, depth) in contents {
        for matrix in matrices {
            let image = DepthImage::new(depth.clone(), seen.image.size, matrix);
            for settings in kinds() {
                let mean = mean(&run(&gpu, &settings, &image).filtered);
                println!(
                    "{name}, {:?}, {:?}: mean {mean:.4}",
                    settings.advanced.kernel, settings.resolution
                );
                assert!(mean == 0.0 || name == "any bits" || name == "noise");
            }
        }
    }
}

fn mean(occlusion: &[f32]) -> f32 {
    occlusion.iter().sum::<f32>() / occlusion.len() as f32
}

/// Values out of a field's range count as its limit; NaN counts as any value in it.
#[test]
fn settings_may_be_anything() {
    const INF: f32 = f32::INFINITY;
    const NAN: f32 = f32::NAN;
    type Set = fn(&mut LeanScreenSpaceAmbientOcclusion) -> &mut f32;
    let gpu = OcclusionGpu::new();
    let seen = corner().with_size(UVec2::new(240, 135)).seen_within(0.0);
    let occlusion = |set: Set, value| {
        let mut settings = LeanScreenSpaceAmbientOcclusion::default();
        *set(&mut settings) = value;
        run(&gpu, &settings, &seen.image).filtered
    };
    let fields: [(_, Set, _, _); 5] = [
        ("radius", |s| &mut s.radius, 0.0, 1e6),
        ("intensity", |s| &mut s.intensity, 0.0, 1e6),
        ("bias", |s| &mut s.advanced.bias, 0.0, FRAC_PI_2),
        ("falloff", |s| &mut s.advanced.falloff, 0.0, 1.0),
        ("thickness", |s| s.thickness.get_or_insert(0.0), 0.0, 1e9),
    ];
    for (name, set, least, most) in fields {
        let [low, high] = [least, most].map(|value| occlusion(set, value));
        println!("{name}: mean {:.4} to {:.4}", mean(&low), mean(&high));
        for value in [-1e-30, -1.0, -1e30, -INF] {
            let errors = difference(&occlusion(set, value), &low);
            assert!(errors.rmse < 1e-3, "{name} {value}: {errors}");
        }
        for value in [1e30, INF] {
            let errors = difference(&occlusion(set, value), &high);
            assert!(errors.rmse < 1e-3, "{name} {value}: {errors}");
        }
        occlusion(set, NAN);
    }
}
