//! What of a surface is not at its default.
//!
//! | bits, low to high | |
//! |---|---|
//! | 8 | specular constant, 0 to 2 in steps of 1/126; stored so that 0 is the default 0.5 |
//! | 3 | [`ShadingModel`](crate::gbuffer::ShadingModel) |
//! | 1 | no fog |
//! | 1 | receives no shadows |
//! | 2 | what the emissive target holds, [`LIGHTMAP_NONE`] … |
//! | 17 | arguments of the shading model |
//!
//! What the arguments are, `shading_models/` says, a file each. Unlit surfaces have no specular constant, shadows or
//! lightmap: all bits but those of the shading model and the fog hold the colour.
//!
//! A word of 0 is a plain surface with nothing but defaults. The specular constant is off by half a step at most.

use super::quantize;

/// Steps of the specular constant.
pub const REFLECTANCE_STEPS: f32 = 126.0;
/// The largest specular constant that is stored.
pub const LARGEST_REFLECTANCE: f32 = 2.0;
/// The code of the default, 0.5.
pub const DEFAULT_REFLECTANCE: u32 = 63;

/// A surface without fog.
pub const NO_FOG: u32 = 1 << 11;
/// A surface that receives no shadows.
pub const NO_SHADOWS: u32 = 1 << 12;
/// The bits that say what the emissive target holds.
pub const LIGHTMAP_BITS: u32 = 3 << 13;
/// It holds emitted light.
pub const LIGHTMAP_NONE: u32 = 0;
/// It holds the exposed light of a lightmap, which is yet to be multiplied by the surface's diffuse colour.
pub const LIGHTMAP_INCIDENT: u32 = 1 << 13;
/// It holds emitted light and what the surface reflects of a lightmap's.
pub const LIGHTMAP_REFLECTED: u32 = 2 << 13;

/// Where the arguments of the shading model begin.
pub const ARGUMENTS_SHIFT: u32 = 15;
/// Bits of a shading model's arguments.
pub const ARGUMENT_BITS: u32 = 17;

/// Packs all but the arguments. `reflectance` is clamped to 0..2, NaN becomes 0.
pub fn pack_specialization(reflectance: f32, shading_model: u32, flags: u32) -> u32 {
    let code = quantize(
        reflectance / LARGEST_REFLECTANCE,
        LARGEST_REFLECTANCE * REFLECTANCE_STEPS,
    );
    (code ^ DEFAULT_REFLECTANCE) | (shading_model << 8) | flags
}

/// The specular constant: `F0` of a dielectric is 0.16 times its square.
pub fn unpack_reflectance(word: u32) -> f32 {
    ((word & 0xff) ^ DEFAULT_REFLECTANCE) as f32 / REFLECTANCE_STEPS
}

/// The number of the shading model.
pub fn unpack_shading_model(word: u32) -> u32 {
    (word >> 8) & 7
}

/// Puts arguments into a packed word.
pub fn with_arguments(word: u32, arguments: u32) -> u32 {
    word | (arguments << ARGUMENTS_SHIFT)
}

/// The arguments of a word.
pub fn unpack_arguments(word: u32) -> u32 {
    word >> ARGUMENTS_SHIFT
}
