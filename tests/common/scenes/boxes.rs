//! The boxes scene of the benches: 1600 meshes on a plane, many point lights, one shadow-casting sun.

use bevy::prelude::*;

/// Spawns everything but the camera.
pub fn spawn(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    materials: &mut Assets<StandardMaterial>,
    point_lights: u32,
) {
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(60.0, 60.0))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.6, 0.6, 0.6),
            perceptual_roughness: 0.6,
            ..default()
        })),
    ));

    let cube = meshes.add(Cuboid::default());
    let ball = meshes.add(Sphere::new(0.5).mesh().ico(4).expect("4 subdivisions"));
    for i in 0..40u32 {
        for j in 0..40u32 {
            let material = materials.add(StandardMaterial {
                base_color: Color::hsl((i * 40 + j) as f32 * 0.225 % 360.0, 0.6, 0.5),
                metallic: (i % 5) as f32 / 4.0,
                perceptual_roughness: 0.1 + (j % 9) as f32 / 10.0,
                ..default()
            });
            commands.spawn((
                Mesh3d(if (i + j) % 2 == 0 {
                    cube.clone()
                } else {
                    ball.clone()
                }),
                MeshMaterial3d(material),
                Transform::from_xyz((i as f32 - 19.5) * 1.4, 0.5, (j as f32 - 19.5) * 1.4),
            ));
        }
    }

    // A low-discrepancy sequence (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences").
    for n in 0..point_lights {
        let r = |a: f32| (0.5 + a * n as f32).fract();
        let (u, v, w) = (r(0.819_172_5), r(0.671_043_6), r(0.549_700_5));
        commands.spawn((
            PointLight {
                color: Color::hsl(360.0 * w, 0.7, 0.7),
                intensity: 20_000.0,
                range: 5.0,
                ..default()
            },
            Transform::from_xyz(40.0 * (u - 0.5), 0.5 + 3.0 * w, 40.0 * (v - 0.5)),
        ));
    }
    commands.spawn((
        DirectionalLight {
            illuminance: 8_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(3.0, 8.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Where the camera of the benches stands.
pub fn camera_transform() -> Transform {
    Transform::from_xyz(0.0, 6.0, 22.0).looking_at(Vec3::new(0.0, 1.0, 0.0), Vec3::Y)
}
