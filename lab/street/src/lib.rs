//! A street by night after rain, built in code: thousands of lamps, neon signs, wet asphalt, lacquer, brushed metal, plants
//! with alpha masks, waving cats of jade and wax, and people under umbrellas who walk by. It needs no files.
//!
//! Each thing has a file: [`buildings`], [`lamps`], [`signs`], [`stalls`], [`plants`], [`cats`], [`figures`] and the
//! [`sky`]; [`geometry`], [`textures`] and [`materials`] build them.

pub mod buildings;
pub mod cats;
pub mod detail;
pub mod figures;
pub mod geometry;
pub mod ground;
pub mod lamps;
pub mod materials;
pub mod plants;
pub mod signs;
pub mod sky;
pub mod stage;
pub mod stalls;
pub mod textures;
pub mod viewpoint;

use bevy::{light::DirectionalLightShadowMap, prelude::*};

pub use crate::{
    detail::Detail,
    figures::{
        NEAREST,
        walk::{Walker, Walking},
    },
    viewpoint::Viewpoint,
};
use crate::{materials::Materials, stage::Stage, textures::Textures};

/// Spawns the street at startup, and lets its people walk. The app spawns the cameras: see [`Viewpoint`] and
/// [`sky::air`].
#[derive(Clone, Copy, Default)]
pub struct StreetPlugin {
    pub detail: Detail,
}

impl Plugin for StreetPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(self.detail)
            .insert_resource(ClearColor(sky::COLOR))
            .insert_resource(GlobalAmbientLight::NONE)
            .insert_resource(DirectionalLightShadowMap {
                size: self.detail.shadow_map_size,
            })
            .add_systems(Startup, spawn)
            .add_systems(Update, figures::walk::walk);
    }
}

/// Spawns everything but cameras.
pub fn spawn(mut stage: Stage, detail: Res<Detail>) {
    let detail = *detail;
    let textures = Textures::new(&mut stage.images, detail.texture_size);
    let materials = Materials::new(&mut stage, &textures);
    ground::spawn(&mut stage, &materials, detail);
    buildings::spawn(&mut stage, &materials, detail);
    signs::spawn(&mut stage, &textures, detail);
    lamps::spawn(&mut stage, &materials, detail);
    stalls::spawn(&mut stage, &materials, detail);
    plants::spawn(&mut stage, &materials, detail);
    cats::spawn(&mut stage, &materials);
    figures::spawn(&mut stage, &materials, detail);
    sky::spawn_moon(&mut stage.commands);
}
