// Highlights stretched along a tangent.
//
// | bits, low to high | |
// |---|---|
// | 7 | strength |
// | 10 | angle of the tangent about the normal, over 180° |
//
// The tangent is off by at most 0.088° about the stored normal, and by 0.095° with the normal's own error.
#define_import_path bevy_lean_deferred::shading_models::anisotropy

#import bevy_lean_deferred::gbuffer::layout::{is_divisor, quantize}

const PI: f32 = 3.14159265;

/// Normal z at which `tangents` switches frames. Not 0, the z of many walls: passes may differ in a normal's last bits.
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

/// Packs the arguments of anisotropy. `normal` must be the unpacked one, so that decoding uses the same frame. Only the direction
/// of `tangent` perpendicular to the normal counts, not its length or sign. Without such a direction, the angle is 0.
fn pack_anisotropy(strength: f32, tangent: vec3<f32>, normal: vec3<f32>) -> u32 {
    let frame = tangents(normal);
    let p = vec2(dot(tangent, frame[0]), dot(tangent, frame[1]));
    let size = abs(p.x) + abs(p.y);
    let is_direction = is_divisor(size);
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

#ifdef STANDARD_MATERIAL_ANISOTROPY
#import bevy_lean_deferred::gbuffer::layout::unpack_normal
#import bevy_pbr::pbr_types::PbrInput

/// Packed arguments of `pbr`, whose packed normal is `normal_word`.
fn arguments_of(pbr: PbrInput, normal_word: u32) -> u32 {
    return pack_anisotropy(pbr.anisotropy_strength, pbr.anisotropy_T, unpack_normal(normal_word));
}

/// Unpacks `arguments` into the input of lighting.
fn specialize(pbr: ptr<function, PbrInput>, arguments: u32) {
    (*pbr).anisotropy_strength = unpack_anisotropy_strength(arguments);
    (*pbr).anisotropy_T = unpack_anisotropy_tangent(arguments, (*pbr).N);
    (*pbr).anisotropy_B = cross((*pbr).N, (*pbr).anisotropy_T);
}
#endif
