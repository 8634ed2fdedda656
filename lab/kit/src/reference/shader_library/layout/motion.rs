//! Motion vectors of two half floats.
//!
//! x low, y high. Bevy's `Rg16Float` motion vectors have the same format, so nothing is rounded twice. 16-bit snorm, with as many
//! bits, would round again (by up to 1.5e-5 of the image) and could not hold motions beyond ±1.

use bevy::math::{Vec2, Vec4, Vec4Swizzles};

/// Largest half float. Longer motions are clamped.
pub const LARGEST_MOTION: f32 = 65504.0;

/// Bits of the half float nearest to `x`, ties to even. WGSL leaves the rounding to the device; all known devices round like this.
fn half_from(x: f32) -> u32 {
    let sign = (x.to_bits() >> 16) & 0x8000;
    let magnitude = x.abs();
    // Halves near `magnitude` are 2^(exponent - 10) apart; at least 2⁻²⁴.
    let exponent = ((magnitude.to_bits() >> 23) as i32 - 127).max(-14);
    let power = |n: i32| f32::from_bits(((n + 127) as u32) << 23);
    let steps = (magnitude * power(10 - exponent)).round_ties_even() as u32;
    // A mantissa that is rounded up to 2048 carries into the exponent.
    sign | ((((exponent + 14) as u32) << 10) + steps)
}

fn float_from(half: u32) -> f32 {
    let exponent = ((half >> 10) & 0x1f) as i32;
    let mantissa = half & 0x3ff;
    let power = |n: i32| f32::from_bits(((n + 127) as u32) << 23);
    let magnitude = match exponent {
        0 => mantissa as f32 * power(-24),
        31 => return f32::NAN,
        _ => (mantissa + 0x400) as f32 * power(exponent - 25),
    };
    if half & 0x8000 == 0 {
        magnitude
    } else {
        -magnitude
    }
}

/// Screen-space motion, in UV units, between two positions in clip space; as in Bevy's `prepass.wgsl`.
pub fn motion_between(clip: Vec4, previous_clip: Vec4) -> Vec2 {
    (clip.xy() / clip.w - previous_clip.xy() / previous_clip.w) * Vec2::new(0.5, -0.5)
}

/// Packs a motion in UV units. NaN components become 0.
pub fn pack_motion(motion: Vec2) -> u32 {
    let [x, y] = motion.to_array().map(|part| {
        let number = if part.is_nan() { 0.0 } else { part };
        half_from(number.clamp(-LARGEST_MOTION, LARGEST_MOTION))
    });
    x | (y << 16)
}

/// Unpacks a motion.
pub fn unpack_motion(word: u32) -> Vec2 {
    Vec2::new(float_from(word & 0xffff), float_from(word >> 16))
}
