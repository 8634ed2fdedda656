//! The built-in scene: a white room with a red wall and a polished floor, open towards the camera. The sun falls through a window on the
//! floor and the red wall, and a ball glows in a corner. Everything else is lit by what these reflect and emit.

use bevy::{camera::Exposure, light::NotShadowCaster, prelude::*};
use bevy_panorbit_camera::PanOrbitCamera;
use kit::example::{
    builder::Builder,
    model::{self, Viewpoint},
    run::SceneReady,
    switch::SwitchedLight,
};

/// Target of the camera, and its distance.
const FOCUS: Vec3 = Vec3::new(0.0, 1.3, 0.0);
const DISTANCE: f32 = 3.9;

/// Corners of the space between the walls, in metres.
const LOW: Vec3 = Vec3::new(-2.5, 0.0, -2.5);
const HIGH: Vec3 = Vec3::new(2.5, 2.8, 3.125);
const WALL: f32 = 0.2;
/// Corners of the window, in the left wall.
const WINDOW_LOW: Vec3 = Vec3::new(LOW.x - WALL, 0.9, -2.1);
const WINDOW_HIGH: Vec3 = Vec3::new(LOW.x, 2.2, -0.3);
/// Side of a tile of the floor.
const TILE: f32 = 0.625;

type Material = Handle<StandardMaterial>;

/// Spawns the sun, low enough to reach the wall across from the window. Exposes for a room, which gets little of the sky's light.
pub fn spawn_lights(
    mut commands: Commands,
    camera: Single<(&mut Exposure, &mut GeneratedEnvironmentMapLight)>,
) {
    let (mut exposure, mut sky) = camera.into_inner();
    *exposure = Exposure { ev100: 9.5 };
    sky.intensity = 45.0;
    commands.insert_resource(ClearColor(Color::srgb(0.8, 0.9, 1.0)));
    commands.spawn((
        SwitchedLight,
        DirectionalLight {
            color: Color::srgb(1.0, 0.93, 0.82),
            illuminance: 20_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(-1.0, 0.32, -0.25).looking_at(Vec3::ZERO, Vec3::Y),
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
    commands: Commands,
    meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
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
        emissive: LinearRgba::rgb(5.0, 2.6, 0.8),
        ..default()
    });
    // Polished stone, smooth and less so.
    let stone = [(0.8, 0.15), (0.45, 0.05)].map(|(light, perceptual_roughness)| {
        materials.add(StandardMaterial {
            base_color: Color::srgb(light, 0.97 * light, 0.92 * light),
            reflectance: 0.9,
            perceptual_roughness,
            ..default()
        })
    });

    let mut room = Builder { commands, meshes };
    walls(&mut room, &white, &red);
    window(&mut room, &white);
    floor(&mut room, &stone);

    let turned = Quat::from_rotation_y(0.4);
    let tall = Transform::from_xyz(0.9, 0.8, -1.8).with_rotation(turned);
    room.add_at(Cuboid::new(0.8, 1.6, 0.8), &green, tall);
    let low_box = Transform::from_xyz(-1.7, 0.3, -1.6).with_rotation(Quat::from_rotation_y(-0.3));
    room.add_at(Cuboid::new(0.8, 0.6, 0.8), &white, low_box);
    let mut ball = |radius: f32, material: &Material, [x, z]: [f32; 2]| {
        let ball = Sphere::new(radius).mesh().uv(64, 32);
        room.add(ball, material, Vec3::new(x, radius, z)).id()
    };
    ball(0.4, &blue, [0.2, 0.3]);
    ball(0.3, &white, [1.5, 0.5]);
    let glow = ball(0.2, &glow, [-1.7, 0.2]);
    room.commands.entity(glow).insert(NotShadowCaster);
}

/// The right wall is red; the left one has an opening for the window.
fn walls(room: &mut Builder, white: &Material, red: &Material) {
    let (outer_low, outer_high) = (LOW - WALL, HIGH + WALL);
    let (low, high) = (WINDOW_LOW, WINDOW_HIGH);
    for (low, high) in [
        // Ceiling, back.
        (outer_low.with_y(HIGH.y), outer_high),
        (outer_low, outer_high.with_z(LOW.z)),
        // Left: below the window, above it, behind it, in front of it.
        (outer_low, Vec3::new(high.x, low.y, HIGH.z)),
        (outer_low.with_y(high.y), outer_high.with_x(high.x)),
        (outer_low, Vec3::new(high.x, HIGH.y, low.z)),
        (outer_low.with_z(high.z), Vec3::new(high.x, HIGH.y, HIGH.z)),
    ] {
        room.add_box(white, low, high);
    }
    room.add_box(red, outer_low.with_x(HIGH.x), outer_high);
}

/// A cross of bars.
fn window(room: &mut Builder, white: &Material) {
    let (low, high) = (WINDOW_LOW, WINDOW_HIGH);
    let half = Vec3::splat(0.03);
    let middle = (low + high) / 2.0;
    room.add_box(
        white,
        middle.with_z(low.z) - half,
        middle.with_z(high.z) + half,
    );
    room.add_box(
        white,
        middle.with_y(low.y) - half,
        middle.with_y(high.y) + half,
    );
}

/// Tiles of two kinds, in turn.
fn floor(room: &mut Builder, stone: &[Material; 2]) {
    let [columns, rows] = [HIGH.x - LOW.x, HIGH.z - LOW.z].map(|length| (length / TILE) as usize);
    for column in 0..columns {
        for row in 0..rows {
            let low = LOW + TILE * Vec3::new(column as f32, 0.0, row as f32);
            let high = low + Vec3::new(TILE, 0.0, TILE);
            room.add_box(&stone[(column + row) % 2], low - WALL * Vec3::Y, high);
        }
    }
}
