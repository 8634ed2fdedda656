//! Properties of a surface that are not at their defaults. `specialization.wgsl` has the bit table.

use bevy_lean_deferred::shader_library::layout::quantize;
pub use bevy_lean_deferred::{
    shader_library::layout::LARGEST_REFLECTANCE, shading_models::ARGUMENT_BITS,
};

/// Steps per unit of the specular constant.
pub const REFLECTANCE_STEPS: f32 = 126.0;
/// Code of the default, 0.5.
pub const DEFAULT_REFLECTANCE: u32 = 63;

/// Flag of a surface without fog.
pub const NO_FOG: u32 = 1 << 11;
/// Flag of a surface that receives no shadows.
pub const NO_SHADOWS: u32 = 1 << 12;

/// Offset of the shading model's arguments, in bits.
pub const ARGUMENTS_SHIFT: u32 = 15;

/// Packs all but the arguments. `reflectance` is clamped to 0..2; NaN becomes 0.
pub fn pack_specialization(reflectance: f32, shading_model: u32, flags: u32) -> u32 {
    let code = quantize(
        reflectance / LARGEST_REFLECTANCE,
        LARGEST_REFLECTANCE * REFLECTANCE_STEPS,
    );
    (code ^ DEFAULT_REFLECTANCE) | (shading_model << 8) | flags
}

/// Specular constant: `F0` of a dielectric is 0.16 times its square.
pub fn unpack_reflectance(word: u32) -> f32 {
    ((word & 0xff) ^ DEFAULT_REFLECTANCE) as f32 / REFLECTANCE_STEPS
}

/// Number of the shading model.
pub fn unpack_shading_model(word: u32) -> u32 {
    (word >> 8) & 7
}

/// Adds arguments to a packed word.
pub fn with_arguments(word: u32, arguments: u32) -> u32 {
    word | (arguments << ARGUMENTS_SHIFT)
}

/// Arguments of the shading model.
pub fn unpack_arguments(word: u32) -> u32 {
    word >> ARGUMENTS_SHIFT
}
