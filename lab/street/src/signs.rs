//! Neon: signs that stand out of the walls, and tubes along the shops, each with its own light.

use bevy::prelude::*;
use fastrand::Rng;

use crate::{
    buildings::{Lot, lots},
    detail::{Detail, STOREY},
    geometry::Geometry,
    materials::{COLORS, LIGHTS, emission},
    stage::Stage,
    textures::Textures,
};

pub fn spawn(stage: &mut Stage, textures: &Textures, detail: Detail) {
    let case = stage.standard.add(StandardMaterial {
        base_color: Color::linear_rgb(0.02, 0.02, 0.02),
        perceptual_roughness: 0.35,
        ..default()
    });
    let faces: Vec<Vec<Handle<StandardMaterial>>> = (textures.signs.iter())
        .map(|letters| {
            let face = |color| {
                stage.standard.add(StandardMaterial {
                    emissive_texture: Some(letters.clone()),
                    ..emission(color, 170.0)
                })
            };
            LIGHTS.map(face).into()
        })
        .collect();
    let tubes = LIGHTS.map(|color| stage.standard.add(emission(color, 330.0)));
    let mut cases = Geometry::default();
    for lot in lots(detail) {
        let mut random = Rng::with_seed(lot.number ^ 0x516);
        for _ in 0..random.usize(1..4) {
            let color = random.usize(0..COLORS);
            let letters = random.usize(0..faces.len());
            let along = lot.width() * (0.8 * random.f32() - 0.4);
            let height = 1.6 + 1.4 * random.f32();
            let up = STOREY + 0.5 + (lot.storeys - 1) as f32 * STOREY * 0.5 * random.f32();
            let sign = Sign { along, up, height };
            sign.spawn(stage, lot, &mut cases, &faces[letters][color]);
            spawn_glow(stage, lot.at(along, up + height / 2.0, 1.0), color, 5_000.0);
        }
        if random.f32() < 0.6 {
            // A tube along the shop.
            let color = random.usize(0..COLORS);
            let mut tube = Geometry::default();
            let half = lot.width() / 2.0 - 0.6;
            let up = STOREY + 0.25;
            tube.bar(lot.at(-half, up, 0.16), lot.at(half, up, 0.16), 0.025, 8);
            stage.place(tube, &tubes[color]);
            spawn_glow(stage, lot.at(0.0, up, 0.5), color, 3_500.0);
        }
    }
    stage.place(cases, &case);
}

struct Sign {
    along: f32,
    up: f32,
    height: f32,
}

impl Sign {
    /// A flat case across the pavement, letters on both faces.
    fn spawn(
        &self,
        stage: &mut Stage,
        lot: Lot,
        cases: &mut Geometry,
        face: &Handle<StandardMaterial>,
    ) {
        let Self { along, up, height } = *self;
        let width = height / 4.0;
        let (near, far) = (0.25, 0.25 + width);
        cases.cuboid(
            lot.at(along - 0.07, up - 0.04, near - 0.04),
            lot.at(along + 0.07, up + height + 0.04, far + 0.04),
        );
        for bar in [0.15, 0.85] {
            let at = up + bar * height;
            cases.bar(lot.at(along, at, 0.0), lot.at(along, at, near), 0.02, 6);
        }
        let mut letters = Geometry::default();
        for front in [-1.0, 1.0] {
            letters.picture(
                lot.at(along + 0.075 * front, up + height / 2.0, (near + far) / 2.0),
                Vec3::X * front * width / 2.0,
                Vec3::Y * height / 2.0,
                Rect::new(0.0, 0.0, 1.0, 1.0),
            );
        }
        stage.place(letters, face);
    }
}

fn spawn_glow(stage: &mut Stage, at: Vec3, color: usize, intensity: f32) {
    stage.commands.spawn((
        PointLight {
            color: LIGHTS[color].into(),
            intensity,
            range: 7.0,
            ..default()
        },
        Transform::from_translation(at),
    ));
}
