// What of a surface is not at its default; twin of `specialization.rs`, which has the bit table, under the same names.
#define_import_path bevy_lean_deferred::gbuffer::layout::specialization

#import bevy_lean_deferred::gbuffer::layout::{is_finite, is_nan, quantize, quantize_roots}

const PLAIN: u32 = 0u;
const SUBSURFACE: u32 = 1u;
const ANISOTROPY: u32 = 2u;
const RIM: u32 = 3u;
const CLEARCOAT: u32 = 4u;
const BACKLIGHT: u32 = 5u;
const UNLIT: u32 = 6u;

const REFLECTANCE_STEPS: f32 = 126.0;
/// The largest specular constant that is stored.
const LARGEST_REFLECTANCE: f32 = 2.0;
/// The code of the default, 0.5.
const DEFAULT_REFLECTANCE: u32 = 63u;

/// A surface without fog.
const NO_FOG: u32 = 1u << 11u;
/// A surface that receives no shadows.
const NO_SHADOWS: u32 = 1u << 12u;
/// The bits that say what the emissive target holds.
const LIGHTMAP_BITS: u32 = 3u << 13u;
/// It holds emitted light.
const LIGHTMAP_NONE: u32 = 0u;
/// It holds the exposed light of a lightmap, which is yet to be multiplied by the surface's diffuse colour.
const LIGHTMAP_INCIDENT: u32 = 1u << 13u;
/// It holds emitted light and what the surface reflects of a lightmap's.
const LIGHTMAP_REFLECTED: u32 = 2u << 13u;

const ARGUMENTS_SHIFT: u32 = 15u;

/// The brightest channel of an unlit colour that is stored.
const LARGEST_UNLIT: f32 = 32768.0;

const PI: f32 = 3.14159265;

/// Packs all but the arguments. `reflectance` is clamped to 0..2, NaN becomes 0.
fn pack_specialization(reflectance: f32, shading_model: u32, flags: u32) -> u32 {
    let code = quantize(reflectance / LARGEST_REFLECTANCE, LARGEST_REFLECTANCE * REFLECTANCE_STEPS);
    return (code ^ DEFAULT_REFLECTANCE) | (shading_model << 8u) | flags;
}

/// The specular constant: `F0` of a dielectric is 0.16 times its square.
fn unpack_reflectance(word: u32) -> f32 {
    return f32((word & 0xffu) ^ DEFAULT_REFLECTANCE) / REFLECTANCE_STEPS;
}

/// The number of the shading model.
fn unpack_shading_model(word: u32) -> u32 {
    return (word >> 8u) & 7u;
}

/// Puts arguments into a packed word.
fn with_arguments(word: u32, arguments: u32) -> u32 {
    return word | (arguments << ARGUMENTS_SHIFT);
}

/// The arguments of a word.
fn unpack_arguments(word: u32) -> u32 {
    return word >> ARGUMENTS_SHIFT;
}

/// Where `tangents` takes another frame. Not at 0, where walls are: passes may differ in a normal's last bits.
const FRAME_SEAM: f32 = -0.3;

/// Two tangents of a unit vector (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
fn tangents(n: vec3<f32>) -> mat2x3<f32> {
    let s = select(-1.0, 1.0, n.z >= FRAME_SEAM);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return mat2x3(
        vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
        vec3(b, s + n.y * n.y * a, -n.y),
    );
}

/// Packs the arguments of anisotropy. `normal` must be the unpacked one, so that decoding finds the same frame; of
/// `tangent`, of any length, what lies across the normal counts, and its sign does not. One without a direction gets
/// the angle 0.
fn pack_anisotropy(strength: f32, tangent: vec3<f32>, normal: vec3<f32>) -> u32 {
    let frame = tangents(normal);
    let p = vec2(dot(tangent, frame[0]), dot(tangent, frame[1]));
    let size = abs(p.x) + abs(p.y);
    let is_direction = is_finite(size) && size >= 1e-30;
    let valid = select(vec2(1.0, 0.0), p / select(1.0, size, is_direction), is_direction);
    let half_turns = atan2(valid.y, valid.x) * (1.0 / PI) + 1.0;
    let angle = u32(half_turns * 1024.0 + 0.5) & 0x3ffu;
    return quantize(strength, 127.0) | (angle << 7u);
}

/// Strength of anisotropy, 0 to 1.
fn unpack_anisotropy_strength(arguments: u32) -> f32 {
    return f32(arguments & 0x7fu) / 127.0;
}

/// Unit tangent along which highlights are stretched, of either sign.
fn unpack_anisotropy_tangent(arguments: u32, normal: vec3<f32>) -> vec3<f32> {
    let frame = tangents(normal);
    let angle = f32((arguments >> 7u) & 0x3ffu) * (PI / 1024.0);
    return frame[0] * cos(angle) + frame[1] * sin(angle);
}

/// Packs the arguments of clearcoat, both 0 to 1.
fn pack_clearcoat(strength: f32, perceptual_roughness: f32) -> u32 {
    return quantize(strength, 255.0) | (quantize(perceptual_roughness, 255.0) << 8u);
}

/// Strength of clearcoat, 0 to 1.
fn unpack_clearcoat_strength(arguments: u32) -> f32 {
    return f32(arguments & 0xffu) / 255.0;
}

/// Perceptual roughness of clearcoat, 0 to 1.
fn unpack_clearcoat_roughness(arguments: u32) -> f32 {
    return f32((arguments >> 8u) & 0xffu) / 255.0;
}

const THICKNESS_STEPS: f32 = 16.0;
const LEAST_THICKNESS_LOG: f32 = -20.0;

/// Packs the arguments of backlight: transmission 0 to 1, thickness in metres.
fn pack_backlight(transmission: f32, thickness: f32, receives_shadows: bool) -> u32 {
    let valid = select(thickness, 0.0, is_nan(thickness));
    let exponent = (log2(max(valid, 1e-30)) - LEAST_THICKNESS_LOG) * THICKNESS_STEPS + 1.5;
    return quantize(transmission, 127.0)
        | (u32(clamp(exponent, 0.0, 511.0)) << 7u)
        | select(0u, 1u << 16u, receives_shadows);
}

/// The part of light that is transmitted, 0 to 1.
fn unpack_backlight_transmission(arguments: u32) -> f32 {
    return f32(arguments & 0x7fu) / 127.0;
}

/// Metres.
fn unpack_backlight_thickness(arguments: u32) -> f32 {
    let code = (arguments >> 7u) & 0x1ffu;
    let thickness = exp2((f32(code) - 1.0) / THICKNESS_STEPS + LEAST_THICKNESS_LOG);
    return select(thickness, 0.0, code == 0u);
}

/// Whether transmitted light is shadowed.
fn unpack_backlight_shadows(arguments: u32) -> bool {
    return (arguments >> 16u) != 0u;
}

/// Packs the arguments of rim light: colour 0 to 1, exponent 1 to 16.
fn pack_rim(color: vec3<f32>, exponent: f32) -> u32 {
    let codes = quantize_roots(color, vec3(15.0));
    let root = sqrt(max((exponent - 1.0) / 15.0, 0.0));
    return codes.r | (codes.g << 4u) | (codes.b << 8u) | (quantize(root, 31.0) << 12u);
}

/// Colour of rim light, 0 to 1.
fn unpack_rim_color(arguments: u32) -> vec3<f32> {
    let codes = vec3(arguments & 0xfu, (arguments >> 4u) & 0xfu, (arguments >> 8u) & 0xfu);
    let root = vec3<f32>(codes) / 15.0;
    return root * root;
}

/// Exponent of rim light, 1 to 16.
fn unpack_rim_exponent(arguments: u32) -> f32 {
    let root = f32((arguments >> 12u) & 0x1fu) / 31.0;
    return 1.0 + 15.0 * root * root;
}

const LEAST_PATH_LOG: f32 = -13.287713;

/// Packs the arguments of subsurface scattering: colour 0 to 1, mean free path in metres.
fn pack_subsurface(color: vec3<f32>, mean_free_path: f32) -> u32 {
    let codes = quantize_roots(color, vec3(15.0, 15.0, 7.0));
    let valid = select(mean_free_path, 0.0, is_nan(mean_free_path));
    let path = 1.0 - log2(max(valid, 1e-30)) / LEAST_PATH_LOG;
    return codes.r | (codes.g << 4u) | (codes.b << 8u) | (quantize(path, 63.0) << 11u);
}

/// Colour of scattered light, 0 to 1.
fn unpack_subsurface_color(arguments: u32) -> vec3<f32> {
    let codes = vec3(arguments & 0xfu, (arguments >> 4u) & 0xfu, (arguments >> 8u) & 0x7u);
    let root = vec3<f32>(codes) / vec3(15.0, 15.0, 7.0);
    return root * root;
}

/// Mean free path of scattered light in metres, 0.1 mm to 1 m.
fn unpack_subsurface_path(arguments: u32) -> f32 {
    let code = f32((arguments >> 11u) & 0x3fu);
    return exp2((1.0 - code / 63.0) * LEAST_PATH_LOG);
}

/// Packs a whole word for an unlit surface: colour 0 to `LARGEST_UNLIT`; a colour with a NaN becomes black. `flags` may
/// have `NO_FOG`.
fn pack_unlit(color: vec3<f32>, shading_model: u32, flags: u32) -> u32 {
    // The NaN of one channel must not depend on which one `max` drops.
    let number = select(color, vec3(0.0), is_nan(color.r + color.g + color.b));
    let valid = clamp(number, vec3(0.0), vec3(LARGEST_UNLIT));
    // The least exponent, from 0, whose power of two is no less than the brightest channel.
    let above = (bitcast<u32>(max(valid.r, max(valid.g, valid.b))) + 0x7fffffu) >> 23u;
    let exponent = max(above, 127u) - 127u;
    let scale = bitcast<f32>((127u - exponent) << 23u);
    let codes = quantize_roots(valid * scale, vec3(255.0));
    return codes.r | (shading_model << 8u) | (flags & NO_FOG) | ((exponent & 7u) << 12u)
        | (codes.g << 15u) | (codes.b << 23u) | ((exponent >> 3u) << 31u);
}

/// Linear colour of an unlit surface's word.
fn unpack_unlit(word: u32) -> vec3<f32> {
    let exponent = ((word >> 12u) & 7u) | ((word >> 31u) << 3u);
    let codes = vec3(word & 0xffu, (word >> 15u) & 0xffu, (word >> 23u) & 0xffu);
    let root = vec3<f32>(codes) / 255.0;
    return root * root * bitcast<f32>((127u + exponent) << 23u);
}
