//! The street, and the pavements along it.

use bevy::prelude::*;

use crate::{
    detail::{Detail, HALF_WIDTH},
    geometry::Geometry,
    materials::Materials,
    stage::Stage,
};

/// Distance of the kerb from the middle of the street, and height of the pavement, in metres.
pub const KERB: f32 = 2.9;
pub const KERB_HEIGHT: f32 = 0.12;

pub fn spawn(stage: &mut Stage, materials: &Materials, detail: Detail) {
    let middle = Vec3::Z * (detail.near + detail.far) / 2.0;
    let half_length = Vec3::NEG_Z * detail.length() / 2.0;
    let mut road = Geometry::default();
    road.rectangle(middle, Vec3::X * KERB, half_length);
    stage.place(road, &materials.asphalt);

    let mut pavement = Geometry::default();
    let mut kerbs = Geometry::default();
    for side in [-1.0, 1.0] {
        let from = Vec3::new(side * KERB, -0.2, detail.far);
        let kerb = Vec3::new(side * (KERB + 0.15), KERB_HEIGHT, detail.near);
        kerbs.cuboid(from, kerb);
        // Extends a little under the houses.
        let half = (HALF_WIDTH + 0.6 - KERB - 0.15) / 2.0;
        pavement.rectangle(
            middle + Vec3::new(side * (KERB + 0.15 + half), KERB_HEIGHT - 0.003, 0.0),
            Vec3::X * half,
            half_length,
        );
    }
    stage.place(kerbs, &materials.concrete);
    stage.place(pavement, &materials.paving);

    // A distant wall at the end of the street.
    let mut end = Geometry::default();
    end.cuboid(
        Vec3::new(-HALF_WIDTH, 0.0, detail.far - 0.3),
        Vec3::new(HALF_WIDTH, 7.0, detail.far),
    );
    stage.place(end, &materials.bricks[3]);
}
