//! The level: an alley of pillars, balls and foliage.

use bevy::{light::cluster::GlobalClusterSettings, prelude::*};

use crate::{
    random::Random,
    scenes::{SceneBuilder, boxes::reserve_clusters, build::material},
};

/// Length in metres.
const LENGTH: f32 = 60.0;
/// Distance in metres between two pairs of meshes.
const PITCH: f32 = 2.0;

/// Spawns the level without lights. Returns a ball that is free to move.
pub(super) fn spawn(s: &mut SceneBuilder) -> Entity {
    reserve_clusters(&mut s.world().resource_mut::<GlobalClusterSettings>());
    s.mesh(
        Plane3d::default().mesh().size(14.0, LENGTH + 20.0),
        material((0.55, 0.5, 0.45), 0.0, 0.3),
        Transform::from_xyz(0.0, 0.0, -LENGTH / 2.0),
    );
    let holes = s.checker([90, 140, 60, 255], [90, 140, 60, 0]);
    let mut random = Random::new(47);
    for pair in 0..(LENGTH / PITCH) as usize {
        for side in [-1.0, 1.0] {
            let height = random.range(0.8, 2.4);
            let mesh: Mesh = match random.below(3) {
                0 => Cuboid::new(0.8, height, 0.8).into(),
                1 => Sphere::new(height / 2.0).mesh().uv(24, 12),
                _ => Cylinder::new(0.4, height).into(),
            };
            let mut channel = || random.range(0.2, 0.9);
            let color = (channel(), channel(), channel());
            let surface = material(color, random.below(2) as f32, random.range(0.1, 0.9));
            let place = Vec3::new(side * 2.6, 0.0, -PITCH * pair as f32);
            s.mesh(
                mesh,
                surface,
                Transform::from_translation(place + Vec3::Y * height / 2.0),
            );
            s.mesh(
                Rectangle::new(0.9, 1.2),
                StandardMaterial {
                    base_color_texture: Some(holes.clone()),
                    alpha_mode: AlphaMode::Mask(0.5),
                    double_sided: true,
                    cull_mode: None,
                    ..default()
                },
                Transform::from_translation(place + Vec3::new(side * 1.2, 0.6, -0.5 * PITCH)),
            );
        }
    }
    s.mesh(
        Sphere::new(0.3).mesh().uv(24, 12),
        material((0.8, 0.2, 0.15), 0.0, 0.5),
        Transform::default(),
    )
}
