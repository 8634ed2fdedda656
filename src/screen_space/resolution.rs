//! Resolution of screen-space effects.

use bevy::prelude::*;

/// Resolution of a screen-space effect.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ScreenSpaceResolution {
    /// One texel per pixel.
    Full,
    /// One texel per 2×2 pixels, upsampled along depth edges.
    #[default]
    Half,
}

impl ScreenSpaceResolution {
    /// All variants, cheapest first.
    pub const ALL: [Self; 2] = [Self::Half, Self::Full];

    /// Pixels per side of a texel.
    pub(super) fn divisor(self) -> u32 {
        match self {
            Self::Full => 1,
            Self::Half => 2,
        }
    }
}

/// Size of a viewport in texels of `divisor` pixels per side.
pub(super) fn texels(viewport_size: UVec2, divisor: u32) -> UVec2 {
    viewport_size
        .map(|side| side.div_ceil(divisor))
        .max(UVec2::ONE)
}
