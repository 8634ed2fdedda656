//! Highlights stretched along a tangent. `anisotropy.wgsl` has the bit table.

use bevy::math::{Vec2, Vec3};
use bevy_lean_deferred::shader_library::layout::quantize;

use crate::reference::shader_library::layout::is_divisor;

/// Value of z at which `tangents` switches frames. Not 0, where walls are: passes may differ in a normal's last bits.
pub const FRAME_SEAM: f32 = -0.3;

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

/// Packs the arguments of anisotropy. `normal` must be the unpacked one, so that decoding uses the same frame. `tangent` may have any
/// length; its component along the normal and its sign are dropped. A tangent without a direction gets the angle 0.
pub fn pack_anisotropy(strength: f32, tangent: Vec3, normal: Vec3) -> u32 {
    let [t, b] = tangents(normal);
    let p = Vec2::new(tangent.dot(t), tangent.dot(b));
    let size = p.x.abs() + p.y.abs();
    let valid = if !is_divisor(size) { Vec2::X } else { p / size };
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
