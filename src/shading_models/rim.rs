//! Rim light along silhouettes. `rim.wgsl` has the bit table.

use bevy::math::Vec3;

use crate::shader_library::layout::{quantize, quantize_roots};

/// Packs the arguments of rim light: colour 0 to 1, exponent 1 to 16.
pub fn pack_rim(color: Vec3, exponent: f32) -> u32 {
    let codes = quantize_roots(color, Vec3::splat(15.0));
    codes[0]
        | (codes[1] << 4)
        | (codes[2] << 8)
        | (quantize(((exponent - 1.0) / 15.0).max(0.0).sqrt(), 31.0) << 12)
}
