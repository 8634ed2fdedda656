//! Stalls with fruit under awnings, crates, and a red gate across the street.

use bevy::prelude::*;
use fastrand::Rng;

use crate::{
    detail::Detail,
    geometry::Geometry,
    ground::{KERB, KERB_HEIGHT},
    materials::{COLORS, LIGHTS, Materials},
    stage::Stage,
};

/// Positions of the first stall and of the gate, along z.
const FIRST: f32 = -4.4;
const GATE: f32 = -1.4;

pub fn spawn(stage: &mut Stage, materials: &Materials, detail: Detail) {
    let mut fruit = Geometry::default();
    fruit.ball(Vec3::ZERO, Vec3::splat(0.055), 12);
    let fruit = stage.meshes.add(fruit.mesh());
    let mut random = Rng::with_seed(15);
    let mut z = FIRST;
    let mut side = -1.0;
    while z > detail.far + 6.0 {
        stall(
            stage,
            materials,
            &fruit,
            Vec3::new(side * (KERB + 0.45), KERB_HEIGHT, z),
            &mut random,
        );
        side = -side;
        z -= 4.0 + 3.0 * random.f32();
    }
    gate(stage, materials);
}

fn stall(
    stage: &mut Stage,
    materials: &Materials,
    fruit: &Handle<Mesh>,
    foot: Vec3,
    random: &mut Rng,
) {
    let out = -foot.x.signum();
    let color = random.usize(0..COLORS);
    let at = |across: f32, up: f32, along: f32| foot + Vec3::new(across * out, up, along);
    let half = 1.15;
    let mut wood = Geometry::default();
    let mut posts = Geometry::default();
    // A table in two steps, towards the street.
    wood.cuboid(at(-0.45, 0.0, -half), at(0.1, 0.85, half));
    wood.cuboid(at(0.1, 0.0, -half), at(0.55, 0.6, half));
    for crate_ in 0..8 {
        let step = crate_ / 4;
        let along = -half + 0.29 + 0.575 * (crate_ % 4) as f32;
        let (across, up) = if step == 0 {
            (-0.18, 0.85)
        } else {
            (0.33, 0.6)
        };
        for (low, high) in [
            ([-0.22, -0.26], [-0.2, 0.26]),
            ([0.2, -0.26], [0.22, 0.26]),
            ([-0.22, -0.27], [0.22, -0.25]),
            ([-0.22, 0.25], [0.22, 0.27]),
        ] {
            wood.cuboid(
                at(across + low[0], up, along + low[1]),
                at(across + high[0], up + 0.13, along + high[1]),
            );
        }
        let kind = &materials.fruits[random.usize(0..COLORS)];
        for fruits in 0..12 {
            let place = Vec2::new((fruits % 3) as f32 - 1.0, (fruits / 3) as f32 - 1.5) * 0.125;
            let wobble = 0.02 * random.f32();
            let at = at(
                across + place.x + wobble,
                up + 0.06 + wobble,
                along + place.y,
            );
            stage.commands.spawn((
                Mesh3d(fruit.clone()),
                MeshMaterial3d(kind.clone()),
                Transform::from_translation(at).with_scale(Vec3::splat(0.9 + 0.4 * random.f32())),
            ));
        }
    }
    for along in [-half, half] {
        posts.bar(at(-0.5, 0.0, along), at(-0.5, 2.35, along), 0.03, 8);
        posts.bar(at(0.6, 0.0, along), at(0.6, 2.05, along), 0.03, 8);
    }
    let mut awning = Geometry::default();
    let (back, front) = (at(-0.6, 2.42, 0.0), at(0.95, 1.98, 0.0));
    awning.rectangle(
        (back + front) / 2.0,
        Vec3::Z * out * (half + 0.15),
        (back - front) / 2.0,
    );
    awning.rectangle(
        front - Vec3::Y * 0.1,
        Vec3::Z * out * (half + 0.15),
        Vec3::Y * 0.1,
    );
    stage.place(wood, &materials.wood);
    stage.place(posts, &materials.trim);
    stage.place(awning, &materials.awnings[color]);
    let mut bulbs = Geometry::default();
    for along in [-0.6, 0.6] {
        let lamp = at(0.25, 1.85, along);
        bulbs.ball(lamp, Vec3::splat(0.06), 12);
        stage.commands.spawn((
            PointLight {
                color: LIGHTS[0].into(),
                intensity: 1_600.0,
                range: 4.0,
                radius: 0.05,
                ..default()
            },
            Transform::from_translation(lamp),
        ));
    }
    stage.place(bulbs, &materials.bulbs[0]);
}

/// Two posts, a beam, and a lintel that rises at its ends.
fn gate(stage: &mut Stage, materials: &Materials) {
    let z = GATE;
    let mut red = Geometry::default();
    let mut dark = Geometry::default();
    for side in [-1.0, 1.0] {
        let foot = Vec3::new(side * 2.6, 0.0, z);
        let top = Vec3::new(side * 2.45, 4.9, z);
        red.cone(foot, top, [0.19, 0.16], 24);
        dark.cone(foot, foot + Vec3::Y * 0.5, [0.24, 0.22], 24);
    }
    red.cuboid(Vec3::new(-3.1, 4.0, z - 0.1), Vec3::new(3.1, 4.28, z + 0.1));
    red.cuboid(
        Vec3::new(-0.25, 4.28, z - 0.08),
        Vec3::new(0.25, 4.9, z + 0.08),
    );
    const PARTS: i32 = 16;
    for part in 0..PARTS {
        let place = |end: i32| {
            let share = end as f32 / PARTS as f32 * 2.0 - 1.0;
            Vec3::new(3.7 * share, 4.98 + 0.3 * share * share, z)
        };
        let (from, to) = (place(part), place(part + 1));
        let turn = Quat::from_rotation_arc(Vec3::X, (to - from).normalize());
        let size = Vec3::new(from.distance(to) + 0.02, 0.24, 0.34);
        red.turned_cuboid((from + to) / 2.0, size, turn);
        let size = size + Vec3::new(0.0, -0.16, 0.14);
        dark.turned_cuboid((from + to) / 2.0 + Vec3::Y * 0.16, size, turn);
    }
    stage.place(red, &materials.lacquer);
    stage.place(dark, &materials.trim);
}
