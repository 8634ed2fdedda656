//! Extent and level of detail of the street.

use bevy::prelude::*;

/// Half of the distance between the buildings, in metres.
pub const HALF_WIDTH: f32 = 4.6;

/// The height of a storey, in metres.
pub const STOREY: f32 = 3.1;

/// Extent and level of detail of the street.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Ends of the street behind and in front of the camera, in metres along z.
    pub near: f32,
    pub far: f32,
    /// Bulbs, each of them a point light without shadows.
    pub bulbs: usize,
    /// Number of lamps with a shadow map each.
    pub shadowed_lamps: usize,
    /// Side of the moon's shadow map, in texels.
    pub shadow_map_size: usize,
    /// Number of walking people.
    pub figures: usize,
    /// Side of tiling textures, in texels; a power of two.
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
