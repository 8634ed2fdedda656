//! Sizes of sparse depth: the depths of four lattices of pixels, beside each other.

use bevy::math::UVec2;

use crate::shader_library::tiles;

/// Pixels from one pixel of a lattice to the next, along each axis. Same value as in `lattice.wgsl`.
pub const SPACING: u32 = 4;

/// Pixels of a lattice along each axis.
fn lattice_size(viewport_size: UVec2) -> UVec2 {
    // Viewports may be empty.
    viewport_size.map(|side| side.div_ceil(SPACING).max(1))
}

/// Size of the texture.
pub fn texture_size(viewport_size: UVec2) -> UVec2 {
    2 * lattice_size(viewport_size)
}

/// Workgroups of the pass that writes it.
pub fn workgroups(viewport_size: UVec2) -> UVec2 {
    tiles::count(lattice_size(viewport_size))
}
