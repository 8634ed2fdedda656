//! Light that enters, scatters and leaves elsewhere; `effects/subsurface/` scatters it.
//!
//! | bits, low to high | |
//! |---|---|
//! | 4, 3, 3 | colour R, G, B (square roots) |
//! | 6 | mean free path, 0.1 mm to 1 m (logarithmic) |
//! | 1 | the base colour is applied before light scatters |
//!
//! The mean free path is off by at most 7.6%. That of a channel is its product with the colour, whose square root is off by 1/30
//! (red) or 1/14 (green, blue).

use bevy::math::Vec3;

use crate::shader_library::layout::{quantize, quantize_roots};

/// Base-2 logarithm of the shortest mean free path in metres.
pub const LEAST_PATH_LOG: f32 = -13.287_713;

/// Largest codes of the colour.
pub const STEPS: Vec3 = Vec3::new(15.0, 7.0, 7.0);

/// Packs the arguments of subsurface scattering: colour 0 to 1, mean free path in metres, and true if the base colour is applied
/// before light scatters.
pub fn pack_subsurface(color: Vec3, mean_free_path: f32, colors_before: bool) -> u32 {
    let codes = quantize_roots(color, STEPS);
    let valid = if mean_free_path.is_nan() {
        0.0
    } else {
        mean_free_path
    };
    let path = 1.0 - valid.max(1e-30).log2() / LEAST_PATH_LOG;
    let color = codes[0] | (codes[1] << 4) | (codes[2] << 7);
    color | (quantize(path, 63.0) << 10) | (u32::from(colors_before) << 16)
}

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
