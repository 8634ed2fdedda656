//! The luminance of a pixel, safe against anything a picture may hold.

use bevy::math::Vec3;

/// ITU-R BT.709-6, 3.2.
pub const WEIGHTS: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);
/// The largest luminance that counts.
pub const LARGEST: f32 = 65504.0;
/// Base-2 logarithms below this, and so black, count as this.
pub const LOWEST_LOG: f32 = -14.0;
/// The luminance with that logarithm.
pub const SMALLEST: f32 = 6.103_515_6e-5;

/// Luminance 0 to [`LARGEST`]; -1 for what is not a number.
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
