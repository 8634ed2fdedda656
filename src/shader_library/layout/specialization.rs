//! What of a surface is not at its default: twin of `specialization.wgsl`.
//!
//! | bits, low to high | |
//! |---|---|
//! | 8 | specular constant, 0 to 2 in steps of 1/126; stored so that 0 is the default 0.5 |
//! | 3 | [`ShadingModel`](crate::gbuffer::ShadingModel) |
//! | 1 | no fog |
//! | 1 | receives no shadows |
//! | 2 | what the emissive target holds, [`LIGHTMAP_NONE`] … |
//! | 17 | arguments of the shading model |
//!
//! | shading model | arguments, low to high |
//! |---|---|
//! | subsurface | colour R 4, G 4, B 3 (square roots), mean free path 6 (logarithmic, 0.1 mm to 1 m) |
//! | anisotropy | strength 7, angle of the tangent about the normal 10 (180°) |
//! | rim | colour R 4, G 4, B 4 (square roots), exponent 5 (1 to 16, quadratic) |
//! | clearcoat | strength 8, perceptual roughness 8 |
//! | backlight | diffuse transmission 7, thickness 9 (0, or logarithmic, 1 µm to 4 km), receives transmitted shadows 1 |
//!
//! [Unlit](pack_unlit) surfaces have no specular constant, shadows or lightmap: all bits but those of the shading model
//! and the fog hold the colour, 8 + 8 + 8 (square roots) and a shared exponent of 4.
//!
//! A word of 0 is a plain surface with nothing but defaults.
//!
//! Largest errors (`tests/layout_optional.rs` measures and bounds them): linear values half a step; the tangent of
//! anisotropy 0.088° about the stored normal, with whose error 0.095°; thickness 2.2%; mean free path 7.6%; exponent of
//! rim light 0.48. Of unlit colours up to 1, 0.71 in 1/255 of sRGB (RMS 0.30); of brighter ones 0.56% of the brightest
//! channel.

use bevy::math::{Vec2, Vec3};

use super::{quantize, quantize_roots};

const REFLECTANCE_STEPS: f32 = 126.0;
/// The largest specular constant that is stored.
pub const LARGEST_REFLECTANCE: f32 = 2.0;
/// The code of the default, 0.5.
const DEFAULT_REFLECTANCE: u32 = 63;

/// A surface without fog.
pub const NO_FOG: u32 = 1 << 11;
/// A surface that receives no shadows.
pub const NO_SHADOWS: u32 = 1 << 12;
/// The bits that say what the emissive target holds.
pub const LIGHTMAP_BITS: u32 = 3 << 13;
/// It holds emitted light.
pub const LIGHTMAP_NONE: u32 = 0;
/// It holds the exposed light of a lightmap, which is yet to be multiplied by the surface's diffuse colour.
pub const LIGHTMAP_INCIDENT: u32 = 1 << 13;
/// It holds emitted light and what the surface reflects of a lightmap's.
pub const LIGHTMAP_REFLECTED: u32 = 2 << 13;

const ARGUMENTS_SHIFT: u32 = 15;
/// Bits of a shading model's arguments.
pub const ARGUMENT_BITS: u32 = 17;

/// The brightest channel of an unlit colour that is stored.
pub const LARGEST_UNLIT: f32 = 32768.0;

/// Packs all but the arguments. `reflectance` is clamped to 0..2, NaN becomes 0.
pub fn pack_specialization(reflectance: f32, shading_model: u32, flags: u32) -> u32 {
    let code = quantize(
        reflectance / LARGEST_REFLECTANCE,
        LARGEST_REFLECTANCE * REFLECTANCE_STEPS,
    );
    (code ^ DEFAULT_REFLECTANCE) | (shading_model << 8) | flags
}

/// The specular constant: `F0` of a dielectric is 0.16 times its square.
pub fn unpack_reflectance(word: u32) -> f32 {
    ((word & 0xff) ^ DEFAULT_REFLECTANCE) as f32 / REFLECTANCE_STEPS
}

/// The number of the shading model.
pub fn unpack_shading_model(word: u32) -> u32 {
    (word >> 8) & 7
}

/// Puts arguments into a packed word.
pub fn with_arguments(word: u32, arguments: u32) -> u32 {
    word | (arguments << ARGUMENTS_SHIFT)
}

/// The arguments of a word.
pub fn unpack_arguments(word: u32) -> u32 {
    word >> ARGUMENTS_SHIFT
}

/// Where `tangents` takes another frame. Not at 0, where walls are: passes may differ in a normal's last bits.
const FRAME_SEAM: f32 = -0.3;

/// Two tangents of a unit vector (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
fn tangents(n: Vec3) -> [Vec3; 2] {
    let sign = if n.z >= FRAME_SEAM { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [
        Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
    ]
}

/// Packs the arguments of anisotropy. `normal` must be the unpacked one, so that decoding finds the same frame; of
/// `tangent`, of any length, what lies across the normal counts, and its sign does not. One without a direction gets
/// the angle 0.
pub fn pack_anisotropy(strength: f32, tangent: Vec3, normal: Vec3) -> u32 {
    let [t, b] = tangents(normal);
    let p = Vec2::new(tangent.dot(t), tangent.dot(b));
    let size = p.x.abs() + p.y.abs();
    let valid = if !size.is_finite() || size < 1e-30 {
        Vec2::X
    } else {
        p / size
    };
    let half_turns = valid.y.atan2(valid.x) * core::f32::consts::FRAC_1_PI + 1.0;
    let angle = (half_turns * 1024.0 + 0.5) as u32 & 0x3ff;
    quantize(strength, 127.0) | (angle << 7)
}

/// Strength of anisotropy, 0 to 1.
pub fn unpack_anisotropy_strength(arguments: u32) -> f32 {
    (arguments & 0x7f) as f32 / 127.0
}

/// Unit tangent along which highlights are stretched, of either sign.
pub fn unpack_anisotropy_tangent(arguments: u32, normal: Vec3) -> Vec3 {
    let [t, b] = tangents(normal);
    let angle = ((arguments >> 7) & 0x3ff) as f32 * (core::f32::consts::PI / 1024.0);
    t * angle.cos() + b * angle.sin()
}

/// Packs the arguments of clearcoat, both 0 to 1.
pub fn pack_clearcoat(strength: f32, perceptual_roughness: f32) -> u32 {
    quantize(strength, 255.0) | (quantize(perceptual_roughness, 255.0) << 8)
}

/// Strength of clearcoat, 0 to 1.
pub fn unpack_clearcoat_strength(arguments: u32) -> f32 {
    (arguments & 0xff) as f32 / 255.0
}

/// Perceptual roughness of clearcoat, 0 to 1.
pub fn unpack_clearcoat_roughness(arguments: u32) -> f32 {
    ((arguments >> 8) & 0xff) as f32 / 255.0
}

const THICKNESS_STEPS: f32 = 16.0;
const LEAST_THICKNESS_LOG: f32 = -20.0;

/// Packs the arguments of backlight: transmission 0 to 1, thickness in metres.
pub fn pack_backlight(transmission: f32, thickness: f32, receives_shadows: bool) -> u32 {
    let valid = if thickness.is_nan() { 0.0 } else { thickness };
    let exponent = (valid.max(1e-30).log2() - LEAST_THICKNESS_LOG) * THICKNESS_STEPS + 1.5;
    quantize(transmission, 127.0)
        | ((exponent.clamp(0.0, 511.0) as u32) << 7)
        | (u32::from(receives_shadows) << 16)
}

/// The part of light that is transmitted, 0 to 1.
pub fn unpack_backlight_transmission(arguments: u32) -> f32 {
    (arguments & 0x7f) as f32 / 127.0
}

/// Metres.
pub fn unpack_backlight_thickness(arguments: u32) -> f32 {
    let code = (arguments >> 7) & 0x1ff;
    let thickness = ((code as f32 - 1.0) / THICKNESS_STEPS + LEAST_THICKNESS_LOG).exp2();
    if code == 0 { 0.0 } else { thickness }
}

/// Whether transmitted light is shadowed.
pub fn unpack_backlight_shadows(arguments: u32) -> bool {
    arguments >> 16 != 0
}

/// Packs the arguments of rim light: colour 0 to 1, exponent 1 to 16.
pub fn pack_rim(color: Vec3, exponent: f32) -> u32 {
    let codes = quantize_roots(color, Vec3::splat(15.0));
    codes[0]
        | (codes[1] << 4)
        | (codes[2] << 8)
        | (quantize(((exponent - 1.0) / 15.0).max(0.0).sqrt(), 31.0) << 12)
}

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

/// Packs a whole word for an unlit surface: colour 0 to [`LARGEST_UNLIT`]; a colour with a NaN becomes black. `flags`
/// may have [`NO_FOG`].
pub fn pack_unlit(color: Vec3, shading_model: u32, flags: u32) -> u32 {
    // The NaN of one channel must not depend on which one `max` drops.
    let valid = if (color.x + color.y + color.z).is_nan() {
        Vec3::ZERO
    } else {
        color.clamp(Vec3::ZERO, Vec3::splat(LARGEST_UNLIT))
    };
    // The least exponent, from 0, whose power of two is no less than the brightest channel.
    let above = (valid.max_element().to_bits() + 0x7f_ffff) >> 23;
    let exponent = above.max(127) - 127;
    let scale = f32::from_bits((127 - exponent) << 23);
    let codes = quantize_roots(valid * scale, Vec3::splat(255.0));
    codes[0]
        | (shading_model << 8)
        | (flags & NO_FOG)
        | ((exponent & 7) << 12)
        | (codes[1] << 15)
        | (codes[2] << 23)
        | ((exponent >> 3) << 31)
}

/// Linear colour of an unlit surface's word.
pub fn unpack_unlit(word: u32) -> Vec3 {
    let exponent = ((word >> 12) & 7) | ((word >> 31) << 3);
    let root = Vec3::new(
        (word & 0xff) as f32,
        ((word >> 15) & 0xff) as f32,
        ((word >> 23) & 0xff) as f32,
    ) / 255.0;
    root * root * f32::from_bits((127 + exponent) << 23)
}
