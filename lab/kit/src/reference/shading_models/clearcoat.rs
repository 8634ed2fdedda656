//! A second, clear layer on top of a surface. `clearcoat.wgsl` has the bit table.

use bevy_lean_deferred::shader_library::layout::quantize;

/// Packs the arguments of clearcoat, both 0 to 1.
pub fn pack_clearcoat(strength: f32, perceptual_roughness: f32) -> u32 {
    quantize(strength, 255.0) | (quantize(perceptual_roughness, 255.0) << 8)
}

/// Strength of clearcoat, 0 to 1.
pub fn unpack_clearcoat_strength(arguments: u32) -> f32 {
    (arguments & 0xff) as f32 / 255.0
}

/// Perceptual roughness of clearcoat, 0 to 1.
pub fn unpack_clearcoat_roughness(arguments: u32) -> f32 {
    ((arguments >> 8) & 0xff) as f32 / 255.0
}
