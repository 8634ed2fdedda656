// Unlit surfaces: the base colour, independent of light.
//
// They have no specular constant or shadows: all bits of the word but those of the shading model and the fog
// hold the colour, 8 + 8 + 8 (square roots) and a shared exponent of 4.
//
// Colours up to 1 are off by at most 0.71 in 1/255 of sRGB (RMS 0.30), brighter ones by 0.56% of the brightest channel.
#define_import_path bevy_lean_deferred::shading_models::unlit

#import bevy_lean_deferred::gbuffer::layout::{is_nan, quantize_roots}
#import bevy_lean_deferred::gbuffer::layout::specialization::{NO_FOG, UNLIT}

/// Brightest channel of an unlit colour that is stored.
const LARGEST_UNLIT: f32 = 32768.0;

/// Packs a whole word for an unlit surface: colour 0 to `LARGEST_UNLIT`; a colour with a NaN becomes black. `flags` may
/// have `NO_FOG`.
fn pack_unlit(color: vec3<f32>, flags: u32) -> u32 {
    // The result must not depend on which channel's NaN `max` drops.
    let number = select(color, vec3(0.0), is_nan(color.r + color.g + color.b));
    let valid = clamp(number, vec3(0.0), vec3(LARGEST_UNLIT));
    // Least exponent, from 0, whose power of two is at least the brightest channel.
    let above = (bitcast<u32>(max(valid.r, max(valid.g, valid.b))) + 0x7fffffu) >> 23u;
    let exponent = max(above, 127u) - 127u;
    let scale = bitcast<f32>((127u - exponent) << 23u);
    let codes = quantize_roots(valid * scale, vec3(255.0));
    return codes.r | (UNLIT << 8u) | (flags & NO_FOG) | ((exponent & 7u) << 12u)
        | (codes.g << 15u) | (codes.b << 23u) | ((exponent >> 3u) << 31u);
}

/// Linear colour of an unlit surface's word.
fn unpack_unlit(word: u32) -> vec3<f32> {
    let exponent = ((word >> 12u) & 7u) | ((word >> 31u) << 3u);
    let codes = vec3(word & 0xffu, (word >> 15u) & 0xffu, (word >> 23u) & 0xffu);
    let root = vec3<f32>(codes) / 255.0;
    return root * root * bitcast<f32>((127u + exponent) << 23u);
}
