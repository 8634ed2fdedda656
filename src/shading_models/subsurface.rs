//! Light that enters scatters and leaves elsewhere. Stored; lit as plain surfaces are. Twin of `subsurface.wgsl`.
//!
//! | bits, low to high | |
//! |---|---|
//! | 4, 4, 3 | colour R, G, B (square roots) |
//! | 6 | mean free path, 0.1 mm to 1 m (logarithmic) |
//!
//! The mean free path is off by 7.6% at most.

use bevy::math::Vec3;

use crate::shader_library::layout::{quantize, quantize_roots};

const LEAST_PATH_LOG: f32 = -13.287_713;

/// Packs the arguments of subsurface scattering: colour 0 to 1, mean free path in metres.
pub fn pack_subsurface(color: Vec3, mean_free_path: f32) -> u32 {
    let codes = quantize_roots(color, Vec3::new(15.0, 15.0, 7.0));
    let valid = if mean_free_path.is_nan() {
        0.0
    } else {
        mean_free_path
    };
    let path = 1.0 - valid.max(1e-30).log2() / LEAST_PATH_LOG;
    codes[0] | (codes[1] << 4) | (codes[2] << 8) | (quantize(path, 63.0) << 11)
}

/// Colour of scattered light, 0 to 1.
pub fn unpack_subsurface_color(arguments: u32) -> Vec3 {
    let root = Vec3::new(
        (arguments & 0xf) as f32 / 15.0,
        ((arguments >> 4) & 0xf) as f32 / 15.0,
        ((arguments >> 8) & 0x7) as f32 / 7.0,
    );
    root * root
}

/// Mean free path of scattered light in metres, 0.1 mm to 1 m.
pub fn unpack_subsurface_path(arguments: u32) -> f32 {
    let code = ((arguments >> 11) & 0x3f) as f32;
    ((1.0 - code / 63.0) * LEAST_PATH_LOG).exp2()
}
