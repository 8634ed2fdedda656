//! Rim light along silhouettes.
//!
//! | bits, low to high | |
//! |---|---|
//! | 4, 4, 4 | colour R, G, B (square roots) |
//! | 5 | exponent, 1 to 16 (quadratic) |
//!
//! The exponent is off by at most 0.48.

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

/// Colour of rim light, 0 to 1.
pub fn unpack_rim_color(arguments: u32) -> Vec3 {
    let root = Vec3::new(
        (arguments & 0xf) as f32,
        ((arguments >> 4) & 0xf) as f32,
        ((arguments >> 8) & 0xf) as f32,
    ) / 15.0;
    root * root
}

/// Exponent of rim light, 1 to 16.
pub fn unpack_rim_exponent(arguments: u32) -> f32 {
    let root = ((arguments >> 12) & 0x1f) as f32 / 31.0;
    1.0 + 15.0 * root * root
}
