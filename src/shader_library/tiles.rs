//! The 8×8 tiles in which compute passes cover a view.

use bevy::math::UVec2;

/// Pixels per side of the tile that one workgroup covers.
pub const TILE_SIDE: u32 = 8;

/// Workgroups that cover `size` pixels.
pub(crate) fn count(size: UVec2) -> UVec2 {
    UVec2::new(size.x.div_ceil(TILE_SIDE), size.y.div_ceil(TILE_SIDE))
}
