//! Luminance of a pixel, robust against any value that a texture may hold.

use bevy::math::Vec3;

/// ITU-R BT.709-6, 3.2.
pub const WEIGHTS: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);
/// Largest luminance; brighter pixels are clamped to it.
pub const LARGEST: f32 = 65504.0;
/// Smallest base-2 logarithm; darker pixels, including black, are clamped to it.
pub const LOWEST_LOG: f32 = -14.0;
/// Luminance whose logarithm is [`LOWEST_LOG`].
pub const SMALLEST: f32 = 6.103_515_6e-5;

/// Luminance, 0 to [`LARGEST`]; -1 for NaN.
pub fn luminance(color: Vec3) -> f32 {
    let y = color.dot(WEIGHTS);
    if y.is_nan() {
        -1.0
    } else {
        y.clamp(0.0, LARGEST)
    }
}

/// Base-2 logarithm, at least [`LOWEST_LOG`].
pub fn log_luminance(y: f32) -> f32 {
    y.max(1e-5).log2().max(LOWEST_LOG)
}
