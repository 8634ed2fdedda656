//! How much of the street there is.

use bevy::prelude::*;

/// Half of the way between the buildings, in metres.
pub const HALF_WIDTH: f32 = 4.6;

/// The height of a storey, in metres.
pub const STOREY: f32 = 3.1;

/// How much of the street there is.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Where it ends behind the camera and before it, in metres along z.
    pub near: f32,
    pub far: f32,
    /// Bulbs, each of them a point light without shadows.
    pub bulbs: usize,
    /// Lamps with a shadow map each.
    pub shadowed_lamps: usize,
    /// Texels on a side of the moon's shadow map.
    pub shadow_map_size: usize,
    /// People who walk.
    pub figures: usize,
    /// Texels on a side of what tiles; a power of two.
    pub texture_size: u32,
}

impl Detail {
    /// For GPUs.
    pub const FULL: Self = Self {
        near: 10.0,
        far: -56.0,
        bulbs: 3_000,
        shadowed_lamps: 6,
        shadow_map_size: 2048,
        figures: 36,
        texture_size: 512,
    };
    /// For browsers and software renderers.
    pub const SMALL: Self = Self {
        near: 10.0,
        far: -28.0,
        bulbs: 600,
        shadowed_lamps: 2,
        shadow_map_size: 1024,
        figures: 10,
        texture_size: 256,
    };

    pub fn length(self) -> f32 {
        self.near - self.far
    }
}

impl Default for Detail {
    fn default() -> Self {
        Self::FULL
    }
}
