//! Smooth dark albedo under strong light, which amplifies rounding by packing.

use bevy::asset::RenderAssetUsages;
use bevy::{camera::ScalingMode, mesh::Indices, mesh::PrimitiveTopology, prelude::*};
use kit::{
    headless::{Headless, Picture},
    own_process::in_own_process,
    scenes::SceneBuilder,
};

use super::{Pictures, report};

const SIZE: UVec2 = UVec2::new(512, 96);
/// The brightest albedo.
const BRIGHTEST: f32 = 0.02;

/// A stripe per colour: grey and three hues, each a gradient from black in vertex colours, which are not quantised.
const STRIPES: [Vec3; 4] = [
    Vec3::ONE,
    Vec3::new(1.0, 0.5, 0.25),
    Vec3::new(0.3, 1.0, 0.6),
    Vec3::new(0.2, 0.3, 1.0),
];

fn stripe(color: Vec3) -> Mesh {
    let positions = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let bright = (color * BRIGHTEST).extend(1.0).to_array();
    let dark = [0.0, 0.0, 0.0, 1.0];
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; 4])
    .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, vec![dark, bright, bright, dark])
    .with_inserted_indices(Indices::U16(vec![0, 1, 2, 0, 2, 3]))
}

fn scene(s: &mut SceneBuilder, illuminance: f32) {
    for (row, color) in STRIPES.into_iter().enumerate() {
        s.mesh(
            stripe(color),
            StandardMaterial {
                perceptual_roughness: 1.0,
                reflectance: 0.0,
                ..default()
            },
            Transform::from_xyz(0.0, row as f32 * 0.25, 0.0).with_scale(Vec3::new(1.0, 0.25, 1.0)),
        );
    }
    s.spawn((
        DirectionalLight {
            illuminance,
            ..default()
        },
        Transform::from_xyz(0.0, 3.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    s.camera(
        Transform::from_xyz(0.5, 0.5, 5.0),
        Projection::Orthographic(OrthographicProjection {
            scaling_mode: ScalingMode::Fixed {
                width: 1.0,
                height: 1.0,
            },
            ..OrthographicProjection::default_3d()
        }),
    );
}

/// Largest step between adjacent pixels along the middle of a stripe, and largest difference between its channels.
fn bands(picture: &Picture, stripe: u32) -> (u8, u8) {
    let rows = picture.size.y / STRIPES.len() as u32;
    let y = picture.size.y - rows * stripe - rows / 2;
    let pixel = |x: u32| {
        let at = (y * picture.size.x + x) as usize * 4;
        &picture.rgba[at..at + 3]
    };
    let (mut step, mut tint) = (0, 0);
    for x in 1..picture.size.x {
        let (last, this) = (pixel(x - 1), pixel(x));
        let differences = last.iter().zip(this).map(|(a, b)| a.abs_diff(*b));
        step = step.max(differences.max().unwrap_or(0));
        let (least, most) = (this.iter().min(), this.iter().max());
        tint = tint.max(most.unwrap_or(&0) - least.unwrap_or(&0));
    }
    (step, tint)
}

#[test]
#[ignore = "nightly: `shaders` has the codes of dark albedo"]
fn dark_gradients_have_no_bands() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        let mut failures = Vec::new();
        for illuminance in [60_000.0, 200_000.0] {
            let pictures = Pictures::of(&mut headless, |s| scene(s, illuminance));
            let name = format!("dark_albedo_{illuminance}");
            let [deferred, lean] = pictures.compare(&name);
            for stripe in 0..STRIPES.len() as u32 {
                let [forward, deferred, lean] =
                    [&pictures.forward, &pictures.deferred, &pictures.lean]
                        .map(|p| bands(p, stripe));
                println!("  stripe {stripe}: step, tint: {forward:?} {deferred:?} {lean:?}");
            }
            // The first stripe is grey.
            let (step, tint) = bands(&pictures.lean, 0);
            let (forward_step, forward_tint) = bands(&pictures.forward, 0);
            if lean.psnr < deferred.psnr.max(49.0)
                || step > forward_step + 5
                || tint > forward_tint + 2
            {
                failures.push(format!("{name}: {lean}, step {step}, tint {tint}"));
            }
        }
        report(&failures);
    });
}
