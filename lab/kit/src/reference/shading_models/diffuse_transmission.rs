//! Light on the back of a surface that is transmitted to its front: Bevy's diffuse transmission. `diffuse_transmission.wgsl` has the bits.

use bevy_lean_deferred::shader_library::layout::quantize;

/// Codes per factor of 2 in thickness.
pub const THICKNESS_STEPS: f32 = 16.0;
/// Base-2 logarithm of the smallest thickness in metres.
pub const LEAST_THICKNESS_LOG: f32 = -20.0;

/// Packs the arguments of diffuse transmission: transmission 0 to 1, thickness in metres.
pub fn pack_diffuse_transmission(transmission: f32, thickness: f32, receives_shadows: bool) -> u32 {
    let valid = if thickness.is_nan() { 0.0 } else { thickness };
    let exponent = (valid.max(1e-30).log2() - LEAST_THICKNESS_LOG) * THICKNESS_STEPS + 1.5;
    quantize(transmission, 127.0)
        | ((exponent.clamp(0.0, 511.0) as u32) << 7)
        | (u32::from(receives_shadows) << 16)
}

/// Share of light that is transmitted, 0 to 1.
pub fn unpack_transmission(arguments: u32) -> f32 {
    (arguments & 0x7f) as f32 / 127.0
}

/// Thickness in metres.
pub fn unpack_thickness(arguments: u32) -> f32 {
    let code = (arguments >> 7) & 0x1ff;
    let thickness = ((code as f32 - 1.0) / THICKNESS_STEPS + LEAST_THICKNESS_LOG).exp2();
    if code == 0 { 0.0 } else { thickness }
}

/// True if transmitted light is shadowed.
pub fn unpack_receives_shadows(arguments: u32) -> bool {
    arguments >> 16 != 0
}
