//! Light with a shared exponent.
//!
//! The format is that of the graphics APIs' RGB9E5 (Segal, Akeley 2010, "OpenGL 3.3", `EXT_texture_shared_exponent`, after Ward
//! 1991, "Real Pixels"): mantissas R 9, G 9, B 9, exponent 5, low to high. From 1.6e-5 to 65504, the error of the brightest channel
//! is at most 1/513 of it, and that of the others at most 1/511 of the brightest; below, at most 3.0e-8
//! (`tests/shaders/layout_optional.rs` measures and bounds these).

use bevy::math::Vec3;

/// Largest value of a channel; brighter ones are clamped.
pub const LARGEST_LIGHT: f32 = 65408.0;

/// 2 to the power of `n`, exact for -126 to 127.
fn power_of_two(n: i32) -> f32 {
    f32::from_bits(((n + 127) as u32) << 23)
}

/// Packs linear, exposed light. Negative values become 0; a colour with a NaN becomes black.
pub fn pack_light(color: Vec3) -> u32 {
    let valid = if (color.x + color.y + color.z).is_nan() {
        Vec3::ZERO
    } else {
        color.clamp(Vec3::ZERO, Vec3::splat(LARGEST_LIGHT))
    };
    let largest = valid.max_element();
    // The exponent bits of a float are the integer part of its logarithm.
    let mut exponent = ((largest.to_bits() >> 23) as i32 - 127).max(-16) + 16;
    // True if rounding carries into a tenth bit of the mantissa.
    if largest * power_of_two(24 - exponent) + 0.5 >= 512.0 {
        exponent += 1;
    }
    let mantissas = valid * power_of_two(24 - exponent) + 0.5;
    mantissas.x as u32
        | ((mantissas.y as u32) << 9)
        | ((mantissas.z as u32) << 18)
        | ((exponent as u32) << 27)
}

/// Unpacks a word of the emissive target.
pub fn unpack_light(word: u32) -> Vec3 {
    let mantissas = Vec3::new(
        (word & 0x1ff) as f32,
        ((word >> 9) & 0x1ff) as f32,
        ((word >> 18) & 0x1ff) as f32,
    );
    mantissas * power_of_two((word >> 27) as i32 - 24)
}
