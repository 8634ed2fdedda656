//! Sizes of the textures of screen-space effects.

use bevy::prelude::*;

/// Size of a viewport in texels of `divisor` pixels per side.
pub(super) fn texels(viewport_size: UVec2, divisor: u32) -> UVec2 {
    viewport_size
        .map(|side| side.div_ceil(divisor))
        .max(UVec2::ONE)
}
