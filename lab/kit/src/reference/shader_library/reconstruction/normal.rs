//! Geometric normal from depth.

use bevy::math::{Mat4, Vec2, Vec3, Vec4Swizzles};
use bevy_lean_deferred::shader_library::reconstruction::position::ProjectionKind;

/// Side, -1 or 1, of the neighbour on an axis that lies on the surface of the centre: the one whose two depths extrapolate best to
/// the centre. `near_*` are the depths one pixel away, `far_*` those two pixels away, on the sides `a` (towards -1) and `b` (towards
/// +1).
pub fn straighter_side(center: f32, near_a: f32, far_a: f32, near_b: f32, far_b: f32) -> f32 {
    let error_a = (2.0 * near_a - far_a - center).abs();
    let error_b = (2.0 * near_b - far_b - center).abs();
    if error_a < error_b { -1.0 } else { 1.0 }
}

/// Slope of depth per pixel, on the flatter side of three pixels: the other side may be an edge. 0 where the centre is in front of
/// both neighbours, since neither side has its slope.
pub fn flatter_slope(before: f32, center: f32, after: f32) -> f32 {
    let (a, b) = (center - before, after - center);
    if a > 0.0 && b < 0.0 {
        return 0.0;
    }
    if a.abs() < b.abs() { a } else { b }
}

/// Unit normal facing the viewer, from view-space positions of the pixel and of the chosen neighbours (`side` is 1 for the right or
/// lower one, -1 for the other). Falls back to facing the viewer if the three are collinear.
pub fn normal_from_positions(
    center: Vec3,
    horizontal: Vec3,
    horizontal_side: f32,
    vertical: Vec3,
    vertical_side: f32,
) -> Vec3 {
    let to_right = (horizontal - center) * horizontal_side;
    let to_bottom = (vertical - center) * vertical_side;
    let n = to_bottom.cross(to_right);
    let largest = n.abs().max_element();
    if !(largest > 0.0 && largest < 1e30) {
        return Vec3::Z;
    }
    (n / largest).normalize()
}

/// Unit normal facing the viewer, from the `slope` of depth along the axes of `ray_at`, at `ray` and `depth`. `view_from` is the
/// matrix of `view_position`. All kinds but [`ProjectionKind::Perspective`] are treated as orthographic. Falls back to facing the
/// viewer if the slope is not finite.
pub fn normal_from_slope(
    view_from: Mat4,
    kind: ProjectionKind,
    ray: Vec2,
    depth: f32,
    slope: Vec2,
) -> Vec3 {
    let m = view_from;
    let n = if kind == ProjectionKind::Perspective {
        let q = m.z_axis.w * depth + m.w_axis.w;
        let across = m.z_axis.w * slope;
        let z = m.w_axis.z;
        -(across * (z * z)).extend((q - across.dot(ray)) * z)
    } else {
        (-m.z_axis.z * slope).extend(1.0 + m.z_axis.xy().dot(slope))
    };
    let size = n.abs().element_sum();
    if !(size > 0.0 && size < 1e30) {
        return Vec3::Z;
    }
    (n / size).normalize()
}
