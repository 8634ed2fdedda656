//! The built-in scene.

use bevy::prelude::*;

use kit::example::model::{LoadingModel, ShownModel};

/// Spawns a row of balls, from rough dielectric to smooth metal, on a floor.
pub fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        ShownModel,
        Mesh3d(meshes.add(Plane3d::default().mesh().size(9.0, 5.0))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.45, 0.43, 0.4),
            perceptual_roughness: 0.6,
            ..default()
        })),
    ));
    let ball = meshes.add(Sphere::new(0.5).mesh().uv(64, 32));
    for row in 0..2 {
        for column in 0..6 {
            commands.spawn((
                ShownModel,
                Mesh3d(ball.clone()),
                MeshMaterial3d(materials.add(StandardMaterial {
                    base_color: Color::hsl(column as f32 * 55.0, 0.65, 0.55),
                    metallic: row as f32,
                    perceptual_roughness: 0.1 + column as f32 * 0.17,
                    ..default()
                })),
                Transform::from_xyz((column as f32 - 2.5) * 1.3, 0.5, (row as f32 - 0.5) * 1.6),
            ));
        }
    }
    commands.insert_resource(LoadingModel(None));
}
