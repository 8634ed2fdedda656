//! Base colour, independent of light. `unlit.wgsl` has the bits.

use bevy::math::Vec3;
pub use bevy_lean_deferred::shading_models::LARGEST_UNLIT;
use bevy_lean_deferred::{shader_library::layout::quantize_roots, shading_models::ShadingModel};

use crate::reference::shader_library::layout::specialization::NO_FOG;

/// Packs a whole word for an unlit surface: colour 0 to [`LARGEST_UNLIT`]; a colour with a NaN becomes black. `flags`
/// may have [`NO_FOG`].
pub fn pack_unlit(color: Vec3, flags: u32) -> u32 {
    // Checked first, since `max` may drop either operand if one is NaN.
    let valid = if (color.x + color.y + color.z).is_nan() {
        Vec3::ZERO
    } else {
        color.clamp(Vec3::ZERO, Vec3::splat(LARGEST_UNLIT))
    };
    // Smallest exponent, at least 0, whose power of two is no less than the brightest channel.
    let above = (valid.max_element().to_bits() + 0x7f_ffff) >> 23;
    let exponent = above.max(127) - 127;
    let scale = f32::from_bits((127 - exponent) << 23);
    let codes = quantize_roots(valid * scale, Vec3::splat(255.0));
    codes[0]
        | ((ShadingModel::Unlit as u32) << 8)
        | (flags & NO_FOG)
        | ((exponent & 7) << 12)
        | (codes[1] << 15)
        | (codes[2] << 23)
        | ((exponent >> 3) << 31)
}

/// Linear colour of an unlit surface's word.
pub fn unpack_unlit(word: u32) -> Vec3 {
    let exponent = ((word >> 12) & 7) | ((word >> 31) << 3);
    let root = Vec3::new(
        (word & 0xff) as f32,
        ((word >> 15) & 0xff) as f32,
        ((word >> 23) & 0xff) as f32,
    ) / 255.0;
    root * root * f32::from_bits((127 + exponent) << 23)
}
