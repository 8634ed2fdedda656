//! Highlights brighter than half floats can store.

use bevy::{post_process::bloom::Bloom, prelude::*};
use kit::{
    hdr::{Light, settled_light},
    headless::{Headless, Picture},
    lean::{judge, report, set_lean, settled, show},
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder},
};

const SIZE: UVec2 = UVec2::new(160, 120);

/// The largest half float.
const LARGEST: f32 = 65504.0;

/// Polished balls that reflect the sun.
fn scene(s: &mut SceneBuilder, illuminance: f32) {
    s.floor();
    for (x, metallic) in [(-1.0, 1.0), (1.0, 0.0)] {
        s.mesh(
            Sphere::new(0.8),
            StandardMaterial {
                perceptual_roughness: 0.089,
                metallic,
                ..Color::srgb(0.9, 0.8, 0.6).into()
            },
            Transform::from_xyz(x, 0.8, 0.0),
        );
    }
    s.spawn((
        DirectionalLight {
            illuminance,
            ..default()
        },
        Transform::from_xyz(1.0, 3.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    s.default_camera(Bloom::NATURAL);
}

fn picture_and_light(headless: &mut Headless, is_lean: bool) -> (Picture, Light) {
    set_lean(headless, is_lean);
    (settled(headless), settled_light(headless))
}

#[test]
fn highlights_are_as_bright_as_a_half_float_can_be() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        show(headless, |s| scene(s, 1e7));
        let (forward, forward_light) = picture_and_light(headless, false);
        let channels = forward_light.texels.iter().flatten();
        let largest = channels.copied().fold(0.0, f32::max);
        if largest < LARGEST {
            println!(
                "skipped: light beyond half floats: forward's own is {largest} at most on this device"
            );
            return;
        }
        let (lean, lean_light) = picture_and_light(headless, true);
        for (name, light) in [("forward", &forward_light), ("lean", &lean_light)] {
            let channels = light.texels.iter().flatten();
            let largest = channels.clone().copied().fold(0.0, f32::max);
            assert_eq!(largest, LARGEST, "{name}");
            assert!(channels.clone().all(|x| x.is_finite()), "{name}");
        }
        report([judge("bright_light", &forward, &lean, LEAST_PSNR)]);
    });
}

/// Lean is finite wherever forward is, also if sums overflow floats.
#[test]
fn light_beyond_all_bounds_is_finite_where_forward_has_it_so() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        show(headless, |s| scene(s, f32::MAX));
        let (_, forward) = picture_and_light(headless, false);
        let (_, lean) = picture_and_light(headless, true);
        let texels = lean.texels.iter().zip(&forward.texels);
        let are_finite = |texel: &[f32; 4]| texel.iter().all(|x| x.is_finite());
        let wrong = texels.filter(|(lean, forward)| are_finite(forward) && !are_finite(lean));
        assert_eq!(wrong.count(), 0);
    });
}
