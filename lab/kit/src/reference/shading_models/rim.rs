//! Rim light along silhouettes.

use bevy::math::Vec3;
pub use bevy_lean_deferred::shading_models::rim::pack_rim;

/// Colour of rim light, 0 to 1.
pub fn unpack_rim_color(arguments: u32) -> Vec3 {
    let root = Vec3::new(
        (arguments & 0xf) as f32,
        ((arguments >> 4) & 0xf) as f32,
        ((arguments >> 8) & 0xf) as f32,
    ) / 15.0;
    root * root
}

/// Exponent of rim light, 1 to 16.
pub fn unpack_rim_exponent(arguments: u32) -> f32 {
    let root = ((arguments >> 12) & 0x1f) as f32 / 31.0;
    1.0 + 15.0 * root * root
}
