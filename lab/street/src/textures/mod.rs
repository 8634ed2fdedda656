//! Textures, made in code.

mod facades;
mod grounds;
mod leaves;
mod noise;
mod signs;
mod texture;

use bevy::prelude::*;

/// Colour, roughness and bumps of a tiling texture.
#[derive(Clone)]
pub struct Tile {
    pub color: Handle<Image>,
    /// Roughness in G, metallic in B.
    pub roughness: Handle<Image>,
    pub normal: Handle<Image>,
}

/// All textures of the street.
pub struct Textures {
    /// 8 m of asphalt with puddles.
    pub asphalt: Tile,
    /// 2 m of slabs.
    pub paving: Tile,
    /// 2 m of bricks.
    pub bricks: Tile,
    /// Rooms behind windows.
    pub windows: Vec<Handle<Image>>,
    /// Invented letters, four in a column.
    pub signs: Vec<Handle<Image>>,
    /// Stripes of an awning.
    pub stripes: Handle<Image>,
    /// A bunch of leaves, alpha-masked.
    pub leaves: Handle<Image>,
}

impl Textures {
    /// Creates all textures; tiling ones have `size` texels per side.
    pub fn new(images: &mut Assets<Image>, size: u32) -> Self {
        Self {
            asphalt: grounds::asphalt(images, size),
            paving: grounds::paving(images, size),
            bricks: facades::bricks(images, size),
            windows: (0..WINDOWS).map(|n| facades::window(images, n)).collect(),
            signs: (0..SIGNS).map(|n| signs::letters(images, n)).collect(),
            stripes: signs::stripes(images),
            leaves: leaves::bunch(images, size / 2),
        }
    }
}

const WINDOWS: u64 = 6;
const SIGNS: u64 = 10;
