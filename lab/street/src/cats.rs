//! Two waving cats, of jade and of wax: light scatters beneath their surfaces.

use bevy::prelude::*;

use crate::{
    geometry::Geometry,
    ground::KERB_HEIGHT,
    materials::{LIGHTS, Materials},
    stage::Stage,
};

/// Positions of the cats.
const PLACES: [Vec3; 2] = [
    Vec3::new(3.15, KERB_HEIGHT, 1.2),
    Vec3::new(-3.15, KERB_HEIGHT, 1.2),
];

pub fn spawn(stage: &mut Stage, materials: &Materials) {
    for (place, material) in PLACES.into_iter().zip([&materials.jade, &materials.wax]) {
        let mut pedestal = Geometry::default();
        pedestal.cuboid(
            place - Vec3::new(0.36, 0.02, 0.36),
            place + Vec3::new(0.36, 0.42, 0.36),
        );
        pedestal.cuboid(
            place + Vec3::new(-0.42, 0.42, -0.42),
            place + Vec3::new(0.42, 0.5, 0.42),
        );
        stage.place(pedestal, &materials.concrete);
        // They look at people who come down the street.
        let turn = Quat::from_rotation_y(-0.35 * place.x.signum());
        let transform = Transform::from_translation(place + Vec3::Y * 0.5).with_rotation(turn);
        let parts = [body(), collar(), eyes()].map(|part| stage.meshes.add(part.mesh()));
        let [body, collar, eyes] = parts;
        stage
            .commands
            .spawn((Mesh3d(body), MeshMaterial3d(material.clone()), transform));
        for (part, material) in [(collar, &materials.gold), (eyes, &materials.eyes)] {
            stage
                .commands
                .spawn((Mesh3d(part), MeshMaterial3d(material.clone()), transform));
        }
        // One lamp behind, one in front.
        let behind = Vec3::new(0.35 * place.x.signum(), 1.1, -0.55);
        for (offset, lumens) in [
            (behind, 2_400.0),
            (Vec3::new(-0.9 * place.x.signum(), 1.5, 1.4), 1_500.0),
        ] {
            stage.commands.spawn((
                PointLight {
                    color: LIGHTS[0].into(),
                    intensity: lumens,
                    range: 3.5,
                    ..default()
                },
                Transform::from_translation(place + offset),
            ));
        }
    }
}

fn body() -> Geometry {
    let mut cat = Geometry::default();
    let mut ball = |at: [f32; 3], radii: [f32; 3]| {
        cat.ball(Vec3::from_array(at), Vec3::from_array(radii), 40);
    };
    ball([0.0, 0.27, 0.0], [0.27, 0.28, 0.24]);
    ball([0.0, 0.42, 0.0], [0.21, 0.26, 0.19]);
    ball([0.0, 0.74, 0.03], [0.235, 0.195, 0.2]);
    // Muzzle and cheeks.
    ball([0.0, 0.69, 0.19], [0.09, 0.06, 0.07]);
    ball([-0.1, 0.68, 0.12], [0.1, 0.08, 0.1]);
    ball([0.1, 0.68, 0.12], [0.1, 0.08, 0.1]);
    // Feet, the resting paw, the waving one, the tail.
    ball([-0.16, 0.06, 0.2], [0.11, 0.075, 0.14]);
    ball([0.16, 0.06, 0.2], [0.11, 0.075, 0.14]);
    ball([0.17, 0.36, 0.17], [0.075, 0.16, 0.085]);
    ball([0.14, 0.24, 0.23], [0.08, 0.065, 0.08]);
    ball([-0.27, 0.62, 0.07], [0.075, 0.2, 0.08]);
    ball([-0.28, 0.85, 0.11], [0.085, 0.09, 0.075]);
    ball([0.2, 0.12, -0.22], [0.16, 0.07, 0.07]);
    for side in [-1.0, 1.0] {
        let foot = Vec3::new(0.13 * side, 0.87, 0.02);
        let tip = Vec3::new(0.18 * side, 1.04, 0.02);
        cat.cone(foot, tip, [0.085, 0.012], 20);
    }
    cat
}

/// A ring around the neck, and a bell.
fn collar() -> Geometry {
    let mut ring = Geometry::default();
    const PARTS: u32 = 32;
    let place = |part: u32| {
        let angle = core::f32::consts::TAU * part as f32 / PARTS as f32;
        Vec3::new(0.19 * angle.sin(), 0.575, 0.175 * angle.cos() + 0.015)
    };
    for part in 0..PARTS {
        ring.bar(place(part), place(part + 1), 0.022, 10);
    }
    ring.ball(Vec3::new(0.0, 0.53, 0.21), Vec3::splat(0.05), 20);
    ring
}

fn eyes() -> Geometry {
    let mut eyes = Geometry::default();
    for side in [-1.0, 1.0] {
        eyes.ball(
            Vec3::new(0.09 * side, 0.785, 0.2),
            Vec3::new(0.028, 0.036, 0.02),
            16,
        );
    }
    eyes.ball(
        Vec3::new(0.0, 0.715, 0.258),
        Vec3::new(0.02, 0.014, 0.012),
        12,
    );
    eyes
}
