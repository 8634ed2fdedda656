//! The built-in scene: a courtyard of 7 by 7 metres where surfaces meet in many ways.

use core::f32::consts::TAU;

use bevy::{light::Skybox, prelude::*};
use bevy_panorbit_camera::PanOrbitCamera;

use kit::example::{
    builder::Builder,
    made_up_sky::made_up_sky,
    model::{self, Viewpoint},
    run::SceneReady,
    switch::SwitchedLight,
};

/// Target of the camera, and its distance.
const FOCUS: Vec3 = Vec3::new(-0.5, 0.7, -1.0);
const DISTANCE: f32 = 8.5;

/// Spawns sun, ambient light and sky, also for files.
pub fn spawn_lights(
    mut commands: Commands,
    camera: Single<Entity, With<Camera3d>>,
    mut images: ResMut<Assets<Image>>,
) {
    commands.spawn((
        SwitchedLight,
        DirectionalLight {
            illuminance: 4_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(3.0, 4.5, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.insert_resource(GlobalAmbientLight {
        brightness: 1_000.0,
        ..default()
    });
    commands.entity(*camera).insert(Skybox {
        image: Some(images.add(made_up_sky())),
        brightness: 1_500.0,
        ..default()
    });
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
            ..default()
        })
    };
    let plaster = rough(Color::srgb(0.86, 0.83, 0.78));
    let stone = rough(Color::srgb(0.7, 0.69, 0.67));
    let wood = rough(Color::srgb(0.62, 0.47, 0.32));
    let clay = rough(Color::srgb(0.72, 0.42, 0.33));
    // Drawn by forward passes with any camera: the clearcoat is not in the G-buffer, and the pane is blended.
    let lacquer = materials.add(StandardMaterial {
        base_color: Color::srgb(0.25, 0.4, 0.6),
        perceptual_roughness: 0.5,
        clearcoat: 1.0,
        ..default()
    });
    let glass = materials.add(StandardMaterial {
        base_color: Color::srgba(0.6, 0.8, 0.75, 0.35),
        alpha_mode: AlphaMode::Blend,
        ..default()
    });

    let mut yard = Builder { commands, meshes };
    ground(&mut yard, &stone);
    walls(&mut yard, &plaster, &wood);
    stairs(&mut yard, &stone);
    columns(&mut yard, &plaster);
    crates(&mut yard, &wood);
    for (radius, x, z) in [(0.5, -0.9, -0.8), (0.25, -0.25, -0.55), (0.15, -0.62, -0.2)] {
        let ball = Sphere::new(radius).mesh().uv(48, 24);
        yard.add(ball, &clay, Vec3::new(x, radius, z));
    }
    let ball = Sphere::new(0.3).mesh().uv(48, 24);
    yard.add(ball, &lacquer, Vec3::new(1.2, 0.3, -1.3));
    let ring = Torus::new(0.25, 0.45);
    yard.add(ring, &clay, Vec3::new(0.3, 0.1, 0.9));
    let pane = Transform::from_xyz(1.2, 0.55, 0.3).with_rotation(Quat::from_rotation_y(0.5));
    yard.add_at(Cuboid::new(0.9, 1.1, 0.02), &glass, pane);
}

/// Slabs with joints between them, on a plane that extends to the horizon.
fn ground(yard: &mut Builder, stone: &Handle<StandardMaterial>) {
    let plane = Plane3d::default().mesh().size(200.0, 200.0);
    yard.add(plane, stone, Vec3::new(0.0, -0.06, 0.0));
    for x in -2..3 {
        for z in -2..3 {
            let corner = Vec3::new(x as f32 * 1.4, 0.0, z as f32 * 1.4);
            let half = Vec3::new(0.67, 0.0, 0.67);
            yard.add_box(stone, corner - half - 0.1 * Vec3::Y, corner + half);
        }
    }
}

/// Plaster with a niche behind, boards on the left.
fn walls(yard: &mut Builder, plaster: &Handle<StandardMaterial>, wood: &Handle<StandardMaterial>) {
    for (low, high) in [
        ([-3.9, -0.1, -4.1], [-0.6, 2.6, -3.5]),
        ([0.4, -0.1, -4.1], [3.5, 2.6, -3.5]),
        ([-0.6, 1.8, -4.1], [0.4, 2.6, -3.5]),
        ([-0.6, -0.1, -4.1], [0.4, 1.8, -3.9]),
        ([-0.6, -0.1, -3.9], [0.4, 0.5, -3.45]),
        ([-3.9, -0.1, -3.5], [-3.55, 2.6, 3.5]),
    ] {
        yard.add_box(plaster, low.into(), high.into());
    }
    for board in 0..8 {
        let bottom = 0.02 + board as f32 * 0.32;
        let low = Vec3::new(-3.6, bottom, -3.5);
        yard.add_box(wood, low, Vec3::new(-3.5, bottom + 0.28, 3.5));
    }
}

/// Five steps up to the corner.
fn stairs(yard: &mut Builder, stone: &Handle<StandardMaterial>) {
    for step in 0..5 {
        let right = -1.3 - step as f32 * 0.36;
        let low = Vec3::new(-3.5, step as f32 * 0.2, -3.5);
        yard.add_box(stone, low, Vec3::new(right, (step + 1) as f32 * 0.2, -2.2));
    }
}

/// Fluted columns that carry a beam.
fn columns(yard: &mut Builder, plaster: &Handle<StandardMaterial>) {
    const FLUTES: u32 = 14;
    for z in [-2.6, -0.8, 1.0] {
        let foot = Vec3::new(2.6, 0.0, z);
        for (height, half_width) in [(0.1, 0.36), (0.25, 0.3)] {
            let half = Vec3::new(half_width, 0.0, half_width);
            yard.add_box(plaster, foot - half, foot + half + height * Vec3::Y);
        }
        yard.add(
            Cylinder::new(0.2, 2.0).mesh().resolution(32),
            plaster,
            foot + 1.1 * Vec3::Y,
        );
        for flute in 0..FLUTES {
            let angle = TAU * flute as f32 / FLUTES as f32;
            let side = 0.2 * Vec3::new(angle.cos(), 0.0, angle.sin());
            yard.add(
                Cylinder::new(0.035, 2.0).mesh().resolution(12),
                plaster,
                foot + side + 1.1 * Vec3::Y,
            );
        }
        let half = Vec3::new(0.3, 0.08, 0.3);
        let capital = foot + 2.1 * Vec3::Y;
        yard.add_box(plaster, capital - half, capital + half);
    }
    yard.add_box(
        plaster,
        Vec3::new(2.35, 2.18, -3.5),
        Vec3::new(2.85, 2.55, 1.4),
    );
}

/// Boxes with raised edges: two side by side, and one on top of each other.
fn crates(yard: &mut Builder, wood: &Handle<StandardMaterial>) {
    for (width, x, y, z, turn) in [
        (0.8, -2.6, 0.0, 0.2, 0.2),
        (0.6, -1.85, 0.0, 0.75, -0.3),
        (0.5, -2.6, 0.8, 0.25, 0.7),
    ] {
        let center =
            Transform::from_xyz(x, y + width / 2.0, z).with_rotation(Quat::from_rotation_y(turn));
        let inner = width * 0.94;
        yard.add_at(Cuboid::from_length(inner), wood, center);
        let bar = width * 0.12;
        let edge = (width - bar) / 2.0;
        for (a, b) in [(-edge, -edge), (-edge, edge), (edge, -edge), (edge, edge)] {
            for (size, offset) in [
                (Vec3::new(width, bar, bar), Vec3::new(0.0, a, b)),
                (Vec3::new(bar, width, bar), Vec3::new(a, 0.0, b)),
                (Vec3::new(bar, bar, width), Vec3::new(a, b, 0.0)),
            ] {
                let place = center * Transform::from_translation(offset);
                yard.add_at(Cuboid::from_size(size), wood, place);
            }
        }
    }
}
