//! How many pixels share what effects find.

use bevy::prelude::*;

/// How many pixels share a texel, in which light is found.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ScreenSpaceResolution {
    /// One texel a pixel.
    Full,
    /// One for each 2×2, scaled up along the edges that depth shows.
    #[default]
    Half,
}

impl ScreenSpaceResolution {
    /// Both of them, cheapest first.
    pub const ALL: [Self; 2] = [Self::Half, Self::Full];

    /// Pixels a side that share a texel.
    pub(super) fn divisor(self) -> u32 {
        match self {
            Self::Full => 1,
            Self::Half => 2,
        }
    }
}

/// Texels of so many pixels a side in a viewport.
pub(super) fn texels(viewport_size: UVec2, divisor: u32) -> UVec2 {
    viewport_size
        .map(|side| side.div_ceil(divisor))
        .max(UVec2::ONE)
}
