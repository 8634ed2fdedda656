//! Luminance of a pixel.

use bevy::math::Vec3;

/// ITU-R BT.709-6, 3.2.
pub const WEIGHTS: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);
/// Largest luminance; brighter pixels are clamped to it.
pub const LARGEST: f32 = 65504.0;
/// Smallest base-2 logarithm; darker pixels, including black, are clamped to it.
pub const LOWEST_LOG: f32 = -14.0;
/// Luminance whose logarithm is [`LOWEST_LOG`].
pub const SMALLEST: f32 = 6.103_515_6e-5;
