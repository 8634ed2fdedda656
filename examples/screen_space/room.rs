//! The built-in scene: a white room with a red and a green wall, open towards the camera. The sun lights a patch of the
//! floor, and a lamp the red wall. Everything else is lit by these two patches.

use bevy::{light::NotShadowCaster, prelude::*};
use bevy_panorbit_camera::PanOrbitCamera;
use kit::example::{
    builder::Builder,
    model::{self, Viewpoint},
    run::SceneReady,
    switch::SwitchedLight,
};

/// Target of the camera, and its distance.
const FOCUS: Vec3 = Vec3::new(0.0, 1.4, 0.0);
const DISTANCE: f32 = 6.5;

/// Half of the room's width, its height, and half of its depth, in metres.
const HALF: f32 = 2.5;
const HEIGHT: f32 = 2.8;

pub fn spawn_sun(mut commands: Commands) {
    commands.spawn((
        SwitchedLight,
        DirectionalLight {
            illuminance: 20_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(1.0, 2.0, 2.6).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

pub fn stand_camera(
    mut commands: Commands,
    camera: Single<(&mut Transform, &mut PanOrbitCamera)>,
    viewpoint: Res<Viewpoint>,
) {
    let (mut transform, mut orbit) = camera.into_inner();
    model::stand(&mut transform, &mut orbit, FOCUS, *viewpoint, DISTANCE);
    commands.insert_resource(SceneReady);
}

pub fn spawn(
    mut commands: Commands,
    meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        SwitchedLight,
        SpotLight {
            intensity: 1_500_000.0,
            range: 20.0,
            outer_angle: 0.5,
            inner_angle: 0.3,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(1.6, 2.6, 1.0).looking_at(Vec3::new(-HALF, 1.2, 0.2), Vec3::Y),
    ));
    let mut rough = |color: Color| {
        materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 0.9,
            reflectance: 0.2,
            ..default()
        })
    };
    let white = rough(Color::srgb(0.85, 0.84, 0.82));
    let red = rough(Color::srgb(0.75, 0.12, 0.1));
    let green = rough(Color::srgb(0.15, 0.6, 0.2));
    let blue = rough(Color::srgb(0.25, 0.35, 0.75));
    let glow = materials.add(StandardMaterial {
        base_color: Color::BLACK,
        emissive: LinearRgba::rgb(6.0, 3.6, 1.2),
        ..default()
    });
    // From a mirror to barely one, from left to right.
    let mirrors = [0.0, 0.1, 0.25, 0.45].map(|perceptual_roughness| {
        materials.add(StandardMaterial {
            base_color: Color::srgb(0.95, 0.93, 0.9),
            metallic: 1.0,
            perceptual_roughness,
            ..default()
        })
    });
    let mut room = Builder { commands, meshes };
    let wall = 0.2;
    let (low, high) = (Vec3::new(-HALF, 0.0, -HALF), Vec3::new(HALF, HEIGHT, HALF));
    room.add_box(
        &white,
        low - wall,
        Vec3::new(high.x, 0.0, high.z) + Vec3::X * wall,
    );
    room.add_box(
        &white,
        Vec3::new(low.x, high.y, low.z) - Vec3::X * wall,
        high + wall,
    );
    room.add_box(
        &white,
        low - wall,
        Vec3::new(high.x, high.y, low.z) + Vec3::X * wall,
    );
    room.add_box(&red, low - wall, Vec3::new(low.x, high.y, high.z));
    room.add_box(
        &green,
        Vec3::new(high.x, low.y, low.z),
        high + Vec3::X * wall,
    );

    for (i, mirror) in mirrors.iter().enumerate() {
        let width = 2.0 * HALF / mirrors.len() as f32;
        let corner = Vec3::new(-HALF + i as f32 * width, 0.0, 0.2);
        let size = Vec3::new(width - 0.05, 0.01, HALF - 0.2);
        room.add_box(mirror, corner, corner + size);
    }

    let turned = Quat::from_rotation_y(0.4);
    let tall = Transform::from_xyz(-1.0, 0.8, -0.9).with_rotation(turned);
    room.add_at(Cuboid::new(0.9, 1.6, 0.9), &white, tall);
    let low_box = Transform::from_xyz(1.1, 0.35, 0.3).with_rotation(Quat::from_rotation_y(-0.3));
    room.add_at(Cuboid::new(0.9, 0.7, 0.9), &white, low_box);
    room.add(
        Sphere::new(0.45).mesh().uv(64, 32),
        &blue,
        Vec3::new(0.1, 0.45, 0.9),
    );
    room.add(
        Sphere::new(0.18).mesh().uv(64, 32),
        &glow,
        Vec3::new(1.9, 0.18, -1.7),
    )
    .insert(NotShadowCaster);
}
