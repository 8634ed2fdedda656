//! Light that enters, scatters and leaves elsewhere; `effects/subsurface/` scatters it. `subsurface.wgsl` has the bit table.

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
