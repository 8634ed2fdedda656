//! Houses on both sides: a shop below, windows with sills, balconies and pipes above.

use bevy::prelude::*;
use fastrand::Rng;

use crate::{
    detail::{Detail, HALF_WIDTH, STOREY},
    geometry::Geometry,
    ground::KERB_HEIGHT,
    materials::Materials,
    stage::Stage,
};

/// A house front.
#[derive(Clone, Copy)]
pub struct Lot {
    /// -1 on the left, 1 on the right.
    pub side: f32,
    /// Nearer and farther end, along z.
    pub from: f32,
    pub to: f32,
    pub storeys: u32,
    /// Seed of its looks.
    pub number: u64,
}

impl Lot {
    pub fn width(self) -> f32 {
        self.from - self.to
    }

    /// A point of the front: metres from its middle along the street, above the ground, and out of the wall.
    pub fn at(self, along: f32, up: f32, out: f32) -> Vec3 {
        let z = (self.from + self.to) / 2.0 + along;
        Vec3::new(self.side * (HALF_WIDTH - out), KERB_HEIGHT + up, z)
    }

    /// Direction out of the wall.
    pub fn out(self) -> Vec3 {
        Vec3::NEG_X * self.side
    }

    /// Direction to the right of a viewer in front of it.
    pub fn right(self) -> Vec3 {
        Vec3::Z * self.side
    }
}

/// All houses, from near to far.
pub fn lots(detail: Detail) -> Vec<Lot> {
    let mut lots = Vec::new();
    for side in [-1.0, 1.0] {
        let mut random = Rng::with_seed(if side < 0.0 { 4 } else { 9 });
        let mut from = detail.near;
        while from > detail.far + 3.0 {
            let width = 5.0 + 3.0 * random.f32();
            let to = (from - width).max(detail.far);
            lots.push(Lot {
                side,
                from,
                to,
                storeys: random.u32(2..5),
                number: random.u64(..),
            });
            from = to;
        }
    }
    lots
}

/// Parts of a house by their material.
#[derive(Default)]
struct House {
    wall: Geometry,
    trim: Geometry,
    concrete: Geometry,
    wood: Geometry,
    shutter: Geometry,
    glass: Geometry,
    dark: Geometry,
    lit: Vec<(usize, Geometry)>,
    gold: Geometry,
}

pub fn spawn(stage: &mut Stage, materials: &Materials, detail: Detail) {
    for lot in lots(detail) {
        let mut random = Rng::with_seed(lot.number);
        let mut house = House::default();
        house.walls(lot);
        house.shop(lot, &mut random);
        for storey in 1..lot.storeys {
            house.storey(lot, storey, &mut random);
        }
        let bricks = &materials.bricks[random.usize(0..materials.bricks.len())];
        stage.place(house.wall, bricks);
        stage.place(house.trim, &materials.trim);
        stage.place(house.concrete, &materials.concrete);
        stage.place(house.wood, &materials.wood);
        stage.place(house.shutter, &materials.shutter);
        stage.place(house.glass, &materials.glass);
        stage.place(house.dark, &materials.dark_window);
        stage.place(house.gold, &materials.gold);
        for (room, geometry) in house.lit {
            stage.place(geometry, &materials.windows[room]);
        }
    }
}

impl House {
    /// The front above the shop, the piers beside it, and a cornice.
    fn walls(&mut self, lot: Lot) {
        let half = lot.width() / 2.0;
        let top = lot.storeys as f32 * STOREY;
        self.wall
            .cuboid(lot.at(-half, STOREY, 0.0), lot.at(half, top, -4.0));
        for end in [-half, half - 0.5] {
            self.wall
                .cuboid(lot.at(end, -0.2, 0.0), lot.at(end + 0.5, STOREY, -1.0));
        }
        self.concrete
            .cuboid(lot.at(-half, top, 0.18), lot.at(half, top + 0.35, -4.0));
        self.concrete.cuboid(
            lot.at(-half, STOREY - 0.12, 0.1),
            lot.at(half, STOREY + 0.1, -1.0),
        );
        // A rain pipe.
        let pipe = half - 0.25;
        self.trim
            .bar(lot.at(pipe, 0.0, 0.08), lot.at(pipe, top, 0.08), 0.05, 8);
    }

    /// A shop window with light behind it, or a shutter.
    fn shop(&mut self, lot: Lot, random: &mut Rng) {
        let half = lot.width() / 2.0 - 0.5;
        let back = -0.9;
        if random.f32() < 0.3 {
            self.roller_shutter(lot, half);
            return;
        }
        // The room: floor, ceiling and a back with shelves of light.
        self.wood
            .cuboid(lot.at(-half, -0.1, 0.0), lot.at(half, 0.45, -0.25));
        self.concrete.cuboid(
            lot.at(-half, STOREY - 0.3, -0.2),
            lot.at(half, STOREY, back),
        );
        let panes = ((2.0 * half) / 1.2).round().max(2.0) as usize;
        let width = 2.0 * half / panes as f32;
        let room = random.usize(0..6);
        for pane in 0..panes {
            let along = -half + (pane as f32 + 0.5) * width;
            let mut lit = Geometry::default();
            lit.picture(
                lot.at(along, 1.4, back),
                lot.right() * width / 2.0,
                Vec3::Y * 1.45,
                Rect::new(0.0, 0.0, 1.0, 1.0),
            );
            self.lit.push(((room + pane) % 6, lit));
            self.glass.rectangle(
                lot.at(along, 1.55, -0.12),
                lot.right() * width / 2.0,
                Vec3::Y * 1.25,
            );
            let post = along - width / 2.0;
            self.trim.cuboid(
                lot.at(post - 0.03, 0.3, -0.08),
                lot.at(post + 0.03, STOREY, -0.16),
            );
        }
        // Goods.
        for _ in 0..14 {
            let along = (2.0 * random.f32() - 1.0) * (half - 0.3);
            let size = Vec3::new(0.2, 0.2 + 0.3 * random.f32(), 0.15 + 0.2 * random.f32());
            let middle = lot.at(along, 0.45 + size.y / 2.0, -0.45);
            let turn = Quat::from_rotation_y(random.f32());
            match random.usize(0..3) {
                0 => self.wood.turned_cuboid(middle, size, turn),
                1 => self.gold.ball(middle, size / 2.0, 16),
                _ => self.concrete.turned_cuboid(middle, size, turn),
            }
        }
    }

    /// Slats that stand out along their middles.
    fn roller_shutter(&mut self, lot: Lot, half: f32) {
        const SLAT: f32 = 0.1;
        let count = ((STOREY - 0.1) / SLAT) as u32;
        for slat in 0..count {
            let up = |share: f32| (slat as f32 + share) * SLAT;
            for (from, to) in [((0.0, -0.17), (0.5, -0.15)), ((0.5, -0.15), (1.0, -0.17))] {
                let low = lot.at(0.0, up(from.0), from.1);
                let high = lot.at(0.0, up(to.0), to.1);
                self.shutter
                    .rectangle((low + high) / 2.0, lot.right() * half, (high - low) / 2.0);
            }
        }
    }

    fn storey(&mut self, lot: Lot, storey: u32, random: &mut Rng) {
        let count = (lot.width() / 1.9).floor().max(2.0) as usize;
        let spacing = lot.width() / count as f32;
        let floor = storey as f32 * STOREY;
        let has_balconies = random.f32() < 0.35;
        for window in 0..count {
            let along = -lot.width() / 2.0 + (window as f32 + 0.5) * spacing;
            self.window(lot, along, floor, random);
            if has_balconies && window % 2 == 0 {
                self.balcony(lot, along, floor);
            } else if random.f32() < 0.2 {
                // The box of an air conditioner.
                let low = lot.at(along - 0.38, floor + 0.05, 0.06);
                self.concrete
                    .cuboid(low, lot.at(along + 0.38, floor + 0.55, 0.4));
                let grille = lot.at(along, floor + 0.3, 0.41);
                self.trim
                    .rectangle(grille, lot.right() * 0.3, Vec3::Y * 0.2);
            }
        }
    }

    fn window(&mut self, lot: Lot, along: f32, floor: f32, random: &mut Rng) {
        let half = Vec2::new(0.5, 0.75);
        let up = floor + 1.55;
        let middle = lot.at(along, up, 0.015);
        let (right, rise) = (lot.right() * half.x, Vec3::Y * half.y);
        if random.f32() < 0.5 {
            let mut lit = Geometry::default();
            lit.picture(middle, right, rise, Rect::new(0.0, 0.0, 1.0, 1.0));
            self.lit.push((random.usize(0..6), lit));
        } else {
            self.dark.rectangle(middle, right, rise);
        }
        // Frame, bars and sill.
        for (from, to) in [
            ([-half.x - 0.07, -half.y], [-half.x, half.y]),
            ([half.x, -half.y], [half.x + 0.07, half.y]),
            ([-half.x - 0.07, half.y], [half.x + 0.07, half.y + 0.1]),
            ([-0.025, -half.y], [0.025, half.y]),
            ([-half.x, 0.2], [half.x, 0.25]),
        ] {
            self.wood.cuboid(
                lot.at(along + from[0], up + from[1], 0.0),
                lot.at(along + to[0], up + to[1], 0.07),
            );
        }
        self.concrete.cuboid(
            lot.at(along - half.x - 0.12, up - half.y - 0.1, 0.0),
            lot.at(along + half.x + 0.12, up - half.y, 0.16),
        );
    }

    fn balcony(&mut self, lot: Lot, along: f32, floor: f32) {
        let half = 0.8;
        self.concrete.cuboid(
            lot.at(along - half, floor + 0.02, 0.0),
            lot.at(along + half, floor + 0.14, 0.75),
        );
        for (from, to) in [
            ([-half, 0.7], [half, 0.7]),
            ([-half, 0.0], [-half, 0.7]),
            ([half, 0.0], [half, 0.7]),
        ] {
            let rail = |[x, out]: [f32; 2]| lot.at(along + x, floor + 1.05, out);
            self.trim.bar(rail(from), rail(to), 0.03, 6);
        }
        for post in 0..=12 {
            let x = -half + 2.0 * half * post as f32 / 12.0;
            let foot = lot.at(along + x, floor + 0.1, 0.7);
            self.trim.bar(foot, foot + Vec3::Y * 0.95, 0.012, 4);
        }
    }
}
