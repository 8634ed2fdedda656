//! The outside: a garden in the sun, and all light except the lamp's.

use bevy::{
    light::{CascadeShadowConfigBuilder, Skybox},
    prelude::*,
};

use kit::example::{builder::Builder, made_up_sky::made_up_sky};

type Material = Handle<StandardMaterial>;

/// Height of the lawn, in metres.
const LAWN: f32 = -0.1;

pub fn spawn(
    commands: Commands,
    meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut rough = |color: Color| {
        materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 0.95,
            ..default()
        })
    };
    let grass = rough(Color::srgb(0.3, 0.42, 0.16));
    let leaves = rough(Color::srgb(0.2, 0.36, 0.14));
    let stone = rough(Color::srgb(0.66, 0.64, 0.6));
    let bark = rough(Color::srgb(0.36, 0.27, 0.2));
    let white = rough(Color::srgb(0.9, 0.88, 0.84));
    let tiles = rough(Color::srgb(0.66, 0.31, 0.22));
    let glass = rough(Color::srgb(0.12, 0.15, 0.18));
    let paint = rough(Color::srgb(0.2, 0.4, 0.62));

    let mut garden = Builder { commands, meshes };
    let plane = Plane3d::default().mesh().size(300.0, 300.0);
    garden.add(plane, &grass, LAWN * Vec3::Y);
    path(&mut garden, &stone);
    for (x, z, height) in [(-2.6, -11.5, 3.6), (6.2, -13.0, 4.4), (-7.0, -17.0, 5.0)] {
        tree(&mut garden, &bark, &leaves, Vec3::new(x, LAWN, z), height);
    }
    neighbour(&mut garden, &white, &tiles, &glass);
    for x in -14..14 {
        let low = Vec3::new(x as f32 * 1.1, LAWN, -16.2);
        let height = 1.0 + 0.06 * (x * 5_i32).rem_euclid(3) as f32;
        garden.add_box(&leaves, low, low + Vec3::new(1.12, height, 0.7));
    }
    bench(&mut garden, &paint);
}

/// Slabs that lead away from the door.
fn path(garden: &mut Builder, stone: &Material) {
    for slab in 0..10 {
        let z = -6.3 - slab as f32 * 0.95;
        let x = 1.3 + 0.08 * (slab * 3 % 4) as f32;
        garden.add_box(
            stone,
            Vec3::new(x - 0.55, LAWN - 0.1, z - 0.4),
            Vec3::new(x + 0.55, LAWN + 0.03, z + 0.4),
        );
    }
}

fn tree(garden: &mut Builder, bark: &Material, leaves: &Material, foot: Vec3, height: f32) {
    let trunk = Cylinder::new(0.05 * height, 0.5 * height);
    garden.add(trunk, bark, foot + 0.25 * height * Vec3::Y);
    for (x, y, z, radius) in [
        (0.0, 0.7, 0.0, 0.3),
        (0.2, 0.58, 0.08, 0.2),
        (-0.2, 0.6, -0.04, 0.22),
        (0.04, 0.58, 0.22, 0.19),
    ] {
        let crown = Sphere::new(radius * height).mesh().uv(32, 16);
        garden.add(crown, leaves, foot + height * Vec3::new(x, y, z));
    }
}

/// A white house behind the hedge.
fn neighbour(garden: &mut Builder, white: &Material, tiles: &Material, glass: &Material) {
    let (low, high) = (Vec3::new(-3.0, LAWN, -33.0), Vec3::new(7.0, 3.6, -26.0));
    garden.add_box(white, low, high);
    for side in [-1.0, 1.0] {
        let slope = Quat::from_rotation_x(side * 0.6);
        let ridge = (low + high) / 2.0;
        let center = Vec3::new(ridge.x, high.y + 1.02, ridge.z + side * 1.97);
        garden.add_at(
            Cuboid::new(high.x - low.x + 0.8, 0.15, 4.9),
            tiles,
            Transform::from_translation(center).with_rotation(slope),
        );
    }
    for x in [-1.5, 0.8, 3.1, 5.4] {
        let corner = Vec3::new(x - 0.4, 1.7, high.z);
        garden.add_box(glass, corner, corner + Vec3::new(0.9, 1.3, 0.02));
    }
}

fn bench(garden: &mut Builder, paint: &Material) {
    let corner = Vec3::new(2.6, LAWN, -11.0);
    for (low, high) in [
        ([0.0, 0.42, 0.0], [1.6, 0.48, 0.45]),
        ([0.0, 0.6, -0.05], [1.6, 0.95, 0.0]),
        ([0.1, 0.0, 0.05], [0.18, 0.42, 0.4]),
        ([1.42, 0.0, 0.05], [1.5, 0.42, 0.4]),
        ([0.1, 0.0, -0.05], [0.18, 0.95, 0.0]),
        ([1.42, 0.0, -0.05], [1.5, 0.95, 0.0]),
    ] {
        garden.add_box(paint, corner + Vec3::from(low), corner + Vec3::from(high));
    }
}

/// Spawns sun and sky in photometric units. The light that walls reflect is a guess.
pub fn spawn_lights(
    mut commands: Commands,
    camera: Single<Entity, With<Camera3d>>,
    mut images: ResMut<Assets<Image>>,
) {
    // The sky's light, too, comes from one side, so that the house's shadow maps keep it out.
    for (color, illuminance, from) in [
        (
            Color::srgb(1.0, 0.96, 0.9),
            80_000.0,
            Vec3::new(0.5, 0.9, 0.55),
        ),
        (
            Color::srgb(0.75, 0.85, 1.0),
            12_000.0,
            Vec3::new(-0.4, 0.6, 0.8),
        ),
    ] {
        commands.spawn((
            DirectionalLight {
                color,
                illuminance,
                shadow_maps_enabled: true,
                ..default()
            },
            CascadeShadowConfigBuilder {
                num_cascades: 3,
                first_cascade_far_bound: 7.0,
                maximum_distance: 45.0,
                ..default()
            }
            .build(),
            Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y),
        ));
    }
    let sky = Color::srgb(0.85, 0.92, 1.0);
    // Daylight through the door.
    commands.spawn((
        SpotLight {
            color: sky,
            intensity: 60_000.0,
            range: 20.0,
            inner_angle: 0.5,
            outer_angle: 1.1,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(1.3, 1.6, -6.6).looking_at(Vec3::new(1.3, 0.9, 0.0), Vec3::Y),
    ));
    for (intensity, range, at) in [
        // The sky above the shadow of the house.
        (4_000_000.0, 60.0, Vec3::new(0.0, 6.0, -11.0)),
        // Light reflected by the floor in front of the door.
        (4_000.0, 10.0, Vec3::new(1.5, 0.9, -2.3)),
    ] {
        commands.spawn((
            PointLight {
                color: sky,
                intensity,
                range,
                shadow_maps_enabled: true,
                ..default()
            },
            Transform::from_translation(at),
        ));
    }
    commands.insert_resource(GlobalAmbientLight {
        brightness: 0.4,
        ..default()
    });
    commands.entity(*camera).insert(Skybox {
        image: Some(images.add(made_up_sky())),
        brightness: 6_000.0,
        ..default()
    });
}
