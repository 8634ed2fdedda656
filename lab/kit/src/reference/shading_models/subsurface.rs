//! Light that enters, scatters and leaves elsewhere.

use bevy::math::Vec3;
pub use bevy_lean_deferred::shading_models::subsurface::{LEAST_PATH_LOG, STEPS, pack_subsurface};

/// Colour of scattered light, 0 to 1.
pub fn unpack_subsurface_color(arguments: u32) -> Vec3 {
    let codes = Vec3::new(
        (arguments & 0xf) as f32,
        ((arguments >> 4) & 0x7) as f32,
        ((arguments >> 7) & 0x7) as f32,
    );
    let root = codes / STEPS;
    root * root
}

/// Mean free path of scattered light in metres, 0.1 mm to 1 m.
pub fn unpack_subsurface_path(arguments: u32) -> f32 {
    let code = ((arguments >> 10) & 0x3f) as f32;
    ((1.0 - code / 63.0) * LEAST_PATH_LOG).exp2()
}

/// True if the base colour is applied before light scatters.
pub fn unpack_subsurface_colors_before(arguments: u32) -> bool {
    (arguments >> 16) & 1 != 0
}
