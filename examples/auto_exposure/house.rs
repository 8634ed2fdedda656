//! The inside: a room of 7 by 8 metres with a door in its back wall, and a partition that keeps daylight from one corner.
//!
//! The floor is at a height of 0; -z is towards the door.

use bevy::{light::NotShadowCaster, prelude::*};

use kit::example::builder::Builder;

/// Corners of the space between the walls.
const LOW: Vec3 = Vec3::new(-3.5, 0.0, -5.0);
const HIGH: Vec3 = Vec3::new(3.5, 2.8, 3.0);
const WALL: f32 = 0.25;
/// Extents of the opening in the back wall.
const DOOR_LEFT: f32 = 0.4;
const DOOR_RIGHT: f32 = 2.2;
const DOOR_HEIGHT: f32 = 2.2;
/// Position of the lamp's foot on the table.
const LAMP: Vec3 = Vec3::new(-2.35, 0.76, -3.75);

type Material = Handle<StandardMaterial>;

pub fn spawn(
    commands: Commands,
    meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut rough = |color: Color| {
        materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 0.85,
            ..default()
        })
    };
    let plaster = rough(Color::srgb(0.82, 0.79, 0.73));
    let oak = rough(Color::srgb(0.55, 0.4, 0.27));
    let walnut = rough(Color::srgb(0.38, 0.26, 0.18));
    let cloth = rough(Color::srgb(0.25, 0.38, 0.42));
    let rug = rough(Color::srgb(0.5, 0.2, 0.17));
    let clay = rough(Color::srgb(0.68, 0.38, 0.28));
    let books = [
        Color::srgb(0.55, 0.16, 0.14),
        Color::srgb(0.16, 0.3, 0.45),
        Color::srgb(0.7, 0.58, 0.3),
        Color::srgb(0.2, 0.36, 0.22),
        Color::srgb(0.75, 0.72, 0.65),
    ]
    .map(&mut rough);
    let shade = materials.add(StandardMaterial {
        base_color: Color::srgb(0.9, 0.8, 0.6),
        // In cd/m².
        emissive: LinearRgba::rgb(100.0, 56.0, 22.0),
        emissive_exposure_weight: 1.0,
        ..default()
    });

    let mut house = Builder { commands, meshes };
    walls(&mut house, &plaster);
    floor(&mut house, [&oak, &walnut]);
    door(&mut house, &walnut);
    table(&mut house, &walnut);
    lamp(&mut house, &clay, &shade);
    bookcase(&mut house, &oak, &books);
    armchair(&mut house, &cloth);
    let carpet = Vec3::new(-2.0, 0.0, -2.2);
    house.add(
        Cylinder::new(1.0, 0.02).mesh().resolution(48),
        &rug,
        carpet + 0.01 * Vec3::Y,
    );
    let ball = Sphere::new(0.16).mesh().uv(32, 16);
    house.add(ball, &books[2], Vec3::new(-1.45, 0.18, -2.3));
    picture(&mut house, &walnut, &books);
    chest(&mut house, &oak, &clay);
}

fn walls(house: &mut Builder, plaster: &Material) {
    let (outer_low, outer_high) = (LOW - WALL, HIGH + WALL);
    for (low, high) in [
        // Left, right, front.
        (outer_low, Vec3::new(LOW.x, outer_high.y, outer_high.z)),
        (Vec3::new(HIGH.x, outer_low.y, outer_low.z), outer_high),
        (Vec3::new(outer_low.x, outer_low.y, HIGH.z), outer_high),
        // Left of the door, right of it, and above.
        (outer_low, Vec3::new(DOOR_LEFT, outer_high.y, LOW.z)),
        (
            Vec3::new(DOOR_RIGHT, outer_low.y, outer_low.z),
            Vec3::new(outer_high.x, outer_high.y, LOW.z),
        ),
        (
            Vec3::new(DOOR_LEFT, DOOR_HEIGHT, outer_low.z),
            Vec3::new(DOOR_RIGHT, outer_high.y, LOW.z),
        ),
        // The ceiling.
        (Vec3::new(outer_low.x, HIGH.y, outer_low.z), outer_high),
        // The partition.
        (Vec3::new(-0.45, 0.0, LOW.z), Vec3::new(-0.35, HIGH.y, -1.2)),
    ] {
        house.add_box(plaster, low, high);
    }
}

/// Boards of two woods, and the doorstep.
fn floor(house: &mut Builder, woods: [&Material; 2]) {
    const BOARDS: usize = 28;
    let width = (HIGH.x - LOW.x) / BOARDS as f32;
    for board in 0..BOARDS {
        let left = LOW.x + board as f32 * width;
        house.add_box(
            woods[usize::from(board * 7 % 5 == 0)],
            Vec3::new(left, -WALL, LOW.z),
            Vec3::new(left + width, 0.0, HIGH.z),
        );
    }
    house.add_box(
        woods[1],
        Vec3::new(DOOR_LEFT, -WALL, LOW.z - WALL),
        Vec3::new(DOOR_RIGHT, 0.0, LOW.z),
    );
}

/// Two leaves, open outwards.
fn door(house: &mut Builder, wood: &Material) {
    const LEAF: Vec3 = Vec3::new(0.9, DOOR_HEIGHT - 0.02, 0.05);
    for (hinge, turn) in [(DOOR_LEFT, 1.85_f32), (DOOR_RIGHT, 1.29)] {
        let along = Quat::from_rotation_y(turn) * Vec3::X;
        let center = Vec3::new(hinge, LEAF.y / 2.0 + 0.01, LOW.z - WALL) + along * LEAF.x / 2.0;
        let place = Transform::from_translation(center).with_rotation(Quat::from_rotation_y(turn));
        house.add_at(Cuboid::from_size(LEAF), wood, place);
    }
}

fn table(house: &mut Builder, wood: &Material) {
    let (low, high) = (Vec3::new(-2.75, 0.0, -4.2), Vec3::new(-1.35, 0.76, -3.4));
    house.add_box(wood, low.with_y(0.72), high);
    for (x, z) in [
        (low.x, low.z),
        (low.x, high.z - 0.06),
        (high.x - 0.06, low.z),
        (high.x - 0.06, high.z - 0.06),
    ] {
        house.add_box(
            wood,
            Vec3::new(x, 0.0, z),
            Vec3::new(x + 0.06, 0.72, z + 0.06),
        );
    }
}

fn lamp(house: &mut Builder, foot: &Material, shade: &Material) {
    let at = |height: f32| LAMP + height * Vec3::Y;
    house.add(Cylinder::new(0.09, 0.03), foot, at(0.015));
    house.add(Cylinder::new(0.012, 0.34), foot, at(0.17));
    let cone = ConicalFrustum {
        radius_top: 0.09,
        radius_bottom: 0.16,
        height: 0.2,
    };
    house.add(cone, shade, at(0.42)).insert(NotShadowCaster);
    house.commands.spawn((
        PointLight {
            color: Color::srgb(1.0, 0.72, 0.42),
            // In lumens.
            intensity: 800.0,
            radius: 0.05,
            range: 12.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_translation(at(0.45)),
    ));
}

/// Four shelves of books along the left wall.
fn bookcase(house: &mut Builder, wood: &Material, books: &[Material; 5]) {
    const DEPTH: f32 = 0.3;
    const SHELF: f32 = 0.45;
    let (back, front) = (-4.7, -2.9);
    let (left, right) = (LOW.x, LOW.x + DEPTH);
    for shelf in 0..5 {
        let height = 0.1 + shelf as f32 * SHELF;
        house.add_box(
            wood,
            Vec3::new(left, height - 0.03, back),
            Vec3::new(right, height, front),
        );
        if shelf == 4 {
            break;
        }
        let (mut z, mut book) = (back + 0.05, shelf * 3);
        while z < front - 0.12 {
            let thickness = 0.03 + 0.012 * (book * 5 % 4) as f32;
            let top = height + 0.25 + 0.03 * (book * 7 % 4) as f32;
            house.add_box(
                &books[book % books.len()],
                Vec3::new(left + 0.05, height, z),
                Vec3::new(right - 0.03, top, z + thickness),
            );
            // A gap where a book has been taken out.
            z += thickness + if book % 6 == 5 { 0.1 } else { 0.004 };
            book += 1;
        }
    }
    for z in [back, front - 0.03] {
        house.add_box(
            wood,
            Vec3::new(left, 0.0, z),
            Vec3::new(right, 0.1 + 4.0 * SHELF, z + 0.03),
        );
    }
}

fn armchair(house: &mut Builder, cloth: &Material) {
    let corner = Vec3::new(-1.25, 0.0, -4.6);
    for (low, high) in [
        ([0.0, 0.1, 0.0], [0.75, 0.42, 0.75]),
        ([0.0, 0.1, -0.2], [0.75, 0.95, 0.0]),
        ([-0.12, 0.1, -0.2], [0.0, 0.6, 0.75]),
        ([0.75, 0.1, -0.2], [0.87, 0.6, 0.75]),
    ] {
        house.add_box(cloth, corner + Vec3::from(low), corner + Vec3::from(high));
    }
}

/// A few blocks of colour in a frame, above the table.
fn picture(house: &mut Builder, frame: &Material, colors: &[Material; 5]) {
    let low = Vec3::new(-2.6, 1.45, LOW.z);
    house.add_box(frame, low, low + Vec3::new(1.1, 0.8, 0.03));
    for (color, (x, y, width, height)) in colors.iter().zip([
        (0.06, 0.06, 0.4, 0.3),
        (0.48, 0.06, 0.56, 0.42),
        (0.06, 0.38, 0.4, 0.36),
        (0.48, 0.5, 0.3, 0.24),
        (0.8, 0.5, 0.24, 0.24),
    ]) {
        let corner = low + Vec3::new(x, y, 0.03);
        house.add_box(color, corner, corner + Vec3::new(width, height, 0.01));
    }
}

/// A chest to the right of the door, with a jar on it.
fn chest(house: &mut Builder, wood: &Material, clay: &Material) {
    let corner = Vec3::new(2.75, 0.0, -3.6);
    house.add_box(wood, corner, corner + Vec3::new(0.7, 0.55, 1.4));
    let lid = Vec3::new(0.03, 0.0, 0.03);
    house.add_box(
        wood,
        corner + 0.56 * Vec3::Y - lid,
        corner + Vec3::new(0.7, 0.62, 1.4) + lid.with_x(0.0),
    );
    let jar = corner + Vec3::new(0.35, 0.62, 0.4);
    let belly = Sphere::new(0.17).mesh().uv(32, 16);
    house.add(belly, clay, jar + 0.15 * Vec3::Y);
    house.add(Cylinder::new(0.07, 0.2), clay, jar + 0.35 * Vec3::Y);
}
