//! Bulbs on strings, paper lanterns and street lamps: all of them lights.

use bevy::{light::NotShadowCaster, prelude::*};
use fastrand::Rng;

use crate::{
    buildings::lots,
    detail::{Detail, HALF_WIDTH, STOREY},
    geometry::Geometry,
    ground::KERB,
    materials::{LIGHTS, Materials},
    stage::Stage,
};

/// Distance between two strings, in metres.
const SPACING: f32 = 1.6;
/// Share of the bulbs that hang across the street; the others are along the houses.
const ACROSS: f32 = 0.6;
/// Luminous power of a bulb, in lumens.
const LUMENS: f32 = 75.0;
const RANGE: f32 = 4.2;

pub fn spawn(stage: &mut Stage, materials: &Materials, detail: Detail) {
    let mut ball = Geometry::default();
    ball.ball(Vec3::ZERO, Vec3::splat(0.035), 10);
    let bulb = stage.meshes.add(ball.mesh());
    let mut bulbs = Bulbs {
        stage,
        materials,
        mesh: bulb,
        cables: Geometry::default(),
    };
    bulbs.across(detail);
    bulbs.along_houses(detail);
    let cables = core::mem::take(&mut bulbs.cables);
    stage.place(cables, &materials.trim);
    lanterns(stage, materials, detail);
    street_lamps(stage, materials, detail);
}

struct Bulbs<'a, 'w, 's> {
    stage: &'a mut Stage<'w, 's>,
    materials: &'a Materials,
    mesh: Handle<Mesh>,
    cables: Geometry,
}

impl Bulbs<'_, '_, '_> {
    fn across(&mut self, detail: Detail) {
        let strings = ((detail.length() - 6.0) / SPACING) as usize;
        let each = (detail.bulbs as f32 * ACROSS) as usize / strings.max(1);
        let mut random = Rng::with_seed(2);
        for string in 0..strings {
            let mut end = |side: f32| {
                let z = detail.near - 5.0 - SPACING * (string as f32 + random.f32() - 0.5);
                Vec3::new(side * HALF_WIDTH, 4.3 + 0.7 * random.f32(), z)
            };
            let (from, to) = (end(-1.0), end(1.0));
            self.string(from, to, 0.7, each, string);
        }
    }

    fn along_houses(&mut self, detail: Detail) {
        let lots = lots(detail);
        let each = (detail.bulbs as f32 * (1.0 - ACROSS)) as usize / lots.len().max(1);
        for (number, lot) in lots.iter().enumerate() {
            let half = lot.width() / 2.0 - 0.3;
            let up = STOREY - 0.2;
            self.string(
                lot.at(-half, up, 0.22),
                lot.at(half, up, 0.22),
                0.12,
                each,
                number,
            );
        }
    }

    /// Adds bulbs on a sagging cable.
    fn string(&mut self, from: Vec3, to: Vec3, sag: f32, count: usize, number: usize) {
        let place = |share: f32| from.lerp(to, share) - Vec3::Y * sag * 4.0 * share * (1.0 - share);
        const PARTS: usize = 12;
        for part in 0..PARTS {
            let ends = [part, part + 1].map(|end| place(end as f32 / PARTS as f32));
            self.cables.bar(ends[0], ends[1], 0.008, 4);
        }
        for bulb in 0..count {
            // Warm bulbs, and here and there a string of many colours.
            let color = match number % 5 {
                3 => bulb % LIGHTS.len(),
                1 => 1,
                _ => 0,
            };
            let at = place((bulb as f32 + 0.5) / count as f32) - Vec3::Y * 0.05;
            self.stage.commands.spawn((
                Mesh3d(self.mesh.clone()),
                MeshMaterial3d(self.materials.bulbs[color].clone()),
                NotShadowCaster,
                PointLight {
                    color: LIGHTS[color].into(),
                    intensity: LUMENS,
                    range: RANGE,
                    ..default()
                },
                Transform::from_translation(at),
            ));
        }
    }
}

/// Paper lanterns in front of the shops.
fn lanterns(stage: &mut Stage, materials: &Materials, detail: Detail) {
    let mut body = Geometry::default();
    body.ball(Vec3::ZERO, Vec3::new(0.2, 0.26, 0.2), 20);
    let body = stage.meshes.add(body.mesh());
    let mut rings = Geometry::default();
    for lot in lots(detail) {
        let mut random = Rng::with_seed(lot.number ^ 0x1a2);
        let count = random.usize(0..5);
        let color = [2, 0, 1][random.usize(0..3)];
        for lantern in 0..count {
            let along = lot.width() * ((lantern as f32 + 0.5) / count as f32 - 0.5) * 0.8;
            let at = lot.at(along, STOREY - 0.75, 0.55);
            for end in [0.24, -0.27] {
                let foot = at + Vec3::Y * end;
                rings.bar(foot, foot + Vec3::Y * 0.04, 0.1, 12);
            }
            rings.bar(at + Vec3::Y * 0.26, at + Vec3::Y * 0.7, 0.008, 4);
            stage.commands.spawn((
                Mesh3d(body.clone()),
                MeshMaterial3d(materials.paper[color].clone()),
                NotShadowCaster,
                PointLight {
                    color: LIGHTS[color].into(),
                    intensity: 900.0,
                    range: 5.0,
                    radius: 0.2,
                    ..default()
                },
                Transform::from_translation(at),
            ));
        }
    }
    stage.place(rings, &materials.trim);
}

/// Posts on the pavements, left and right by turns; the first of them cast shadows.
fn street_lamps(stage: &mut Stage, materials: &Materials, detail: Detail) {
    let mut posts = Geometry::default();
    let mut heads = Geometry::default();
    let mut number = 0;
    let mut z = detail.near - 6.5;
    while z > detail.far + 2.0 {
        let side = if number % 2 == 0 { 1.0 } else { -1.0 };
        let foot = Vec3::new(side * (KERB + 0.35), 0.1, z);
        let top = foot + Vec3::Y * 3.9;
        let head = top + Vec3::new(-side * 0.9, 0.15, 0.0);
        posts.cone(foot, foot + Vec3::Y * 0.7, [0.1, 0.06], 10);
        posts.cone(foot + Vec3::Y * 0.7, top, [0.05, 0.035], 10);
        posts.bar(top, head, 0.03, 8);
        posts.cone(
            head - Vec3::Y * 0.05,
            head + Vec3::Y * 0.1,
            [0.22, 0.04],
            12,
        );
        heads.ball(head - Vec3::Y * 0.06, Vec3::new(0.13, 0.06, 0.13), 12);
        stage.commands.spawn((
            SpotLight {
                color: LIGHTS[0].into(),
                intensity: 24_000.0,
                range: 12.0,
                outer_angle: 1.1,
                inner_angle: 0.7,
                radius: 0.1,
                shadow_maps_enabled: number < detail.shadowed_lamps,
                ..default()
            },
            Transform::from_translation(head - Vec3::Y * 0.15)
                .looking_to(Vec3::new(-side * 0.15, -1.0, 0.0), Vec3::Z),
        ));
        number += 1;
        z -= 5.5;
    }
    stage.place(posts, &materials.trim);
    if !heads.is_empty() {
        let mesh = stage.meshes.add(heads.mesh());
        stage.commands.spawn((
            Mesh3d(mesh),
            MeshMaterial3d(materials.lamp.clone()),
            NotShadowCaster,
        ));
    }
}
