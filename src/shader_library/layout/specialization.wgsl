// Properties of a surface that differ from their defaults.
//
// | bits, low to high | |
// |---|---|
// | 8 | specular constant, 0 to 2 in steps of 1/126; stored so that 0 is the default 0.5 |
// | 3 | shading model |
// | 1 | no fog |
// | 1 | receives no shadows |
// | 2 | unused, 0 |
// | 17 | arguments of the shading model |
//
// `shading_models/` documents the arguments, one file per model. Unlit surfaces have no specular constant or shadows: all bits but
// those of the shading model and the fog hold the colour.
//
// A word of 0 is a plain surface with all defaults. The specular constant is off by at most half a step.
#define_import_path bevy_lean_deferred::gbuffer::layout::specialization

#import bevy_lean_deferred::gbuffer::layout::quantize

const PLAIN: u32 = 0u;
const SUBSURFACE: u32 = 1u;
const ANISOTROPY: u32 = 2u;
const RIM: u32 = 3u;
const CLEARCOAT: u32 = 4u;
const DIFFUSE_TRANSMISSION: u32 = 5u;
const UNLIT: u32 = 6u;

const REFLECTANCE_STEPS: f32 = 126.0;
/// Largest specular constant that is stored.
const LARGEST_REFLECTANCE: f32 = 2.0;
/// Code of the default, 0.5.
const DEFAULT_REFLECTANCE: u32 = 63u;

/// Surface without fog.
const NO_FOG: u32 = 1u << 11u;
/// Surface that receives no shadows.
const NO_SHADOWS: u32 = 1u << 12u;

const ARGUMENTS_SHIFT: u32 = 15u;

/// Packs all but the arguments. `reflectance` is clamped to 0..2, NaN becomes 0.
fn pack_specialization(reflectance: f32, shading_model: u32, flags: u32) -> u32 {
    let code = quantize(reflectance / LARGEST_REFLECTANCE, LARGEST_REFLECTANCE * REFLECTANCE_STEPS);
    return (code ^ DEFAULT_REFLECTANCE) | (shading_model << 8u) | flags;
}

/// Specular constant: `F0` of a dielectric is 0.16 times its square.
fn unpack_reflectance(word: u32) -> f32 {
    return f32((word & 0xffu) ^ DEFAULT_REFLECTANCE) / REFLECTANCE_STEPS;
}

/// Number of the shading model.
fn unpack_shading_model(word: u32) -> u32 {
    return (word >> 8u) & 7u;
}

/// Adds arguments to a packed word.
fn with_arguments(word: u32, arguments: u32) -> u32 {
    return word | (arguments << ARGUMENTS_SHIFT);
}

/// Arguments of a word.
fn unpack_arguments(word: u32) -> u32 {
    return word >> ARGUMENTS_SHIFT;
}
