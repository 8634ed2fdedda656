//! Plants in pots along the houses, and ivy from the balconies: crossed pictures of leaves, alpha-masked.

use bevy::prelude::*;
use fastrand::Rng;

use crate::{
    buildings::lots, detail::Detail, geometry::Geometry, materials::Materials, stage::Stage,
};

pub fn spawn(stage: &mut Stage, materials: &Materials, detail: Detail) {
    let mut pots = Geometry::default();
    let mut leaves = Geometry::default();
    for lot in lots(detail) {
        let mut random = Rng::with_seed(lot.number ^ 0x9a7);
        for _ in 0..random.usize(2..6) {
            let along = lot.width() * (0.9 * random.f32() - 0.45);
            let foot = lot.at(along, 0.0, 0.35 + 0.2 * random.f32());
            let size = 0.7 + 0.7 * random.f32();
            pots.cone(foot, foot + Vec3::Y * 0.32, [0.13, 0.2], 14);
            pots.cone(
                foot + Vec3::Y * 0.3,
                foot + Vec3::Y * 0.305,
                [0.19, 0.01],
                14,
            );
            bush(&mut leaves, foot + Vec3::Y * 0.28, size, &mut random);
        }
        // Hangs from a balcony or a sill.
        for storey in 1..lot.storeys {
            if random.f32() < 0.5 {
                let along = lot.width() * (0.8 * random.f32() - 0.4);
                let at = lot.at(along, storey as f32 * 3.1 + 0.75, 0.2);
                bush(&mut leaves, at, 0.6, &mut random);
            }
        }
    }
    stage.place(pots, &materials.pot);
    stage.place(leaves, &materials.leaves);
}

/// Pictures of leaves, turned around a stem and leaning out.
fn bush(leaves: &mut Geometry, foot: Vec3, size: f32, random: &mut Rng) {
    const PICTURES: u32 = 7;
    let start = random.f32();
    for picture in 0..PICTURES {
        let angle = core::f32::consts::TAU * (start + picture as f32 / PICTURES as f32);
        let turn = Quat::from_rotation_y(angle) * Quat::from_rotation_x(0.15 + 0.5 * random.f32());
        let up = turn * Vec3::Y * size / 2.0;
        let right = turn * Vec3::X * size / 2.0;
        leaves.picture(foot + up, right, up, Rect::new(0.0, 0.0, 1.0, 1.0));
    }
}
