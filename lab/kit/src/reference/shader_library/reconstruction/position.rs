//! Positions from depth.

use bevy::math::{Mat4, Vec2, Vec3, Vec3Swizzles, Vec4, Vec4Swizzles};
use bevy_lean_deferred::shader_library::reconstruction::position::ProjectionKind;

/// Keeps positions finite for geometry so distant that its reversed depth is 0.
pub const SMALLEST_DEPTH: f32 = 1e-14;

/// Normalised device coordinates of a fragment. `frag_coord` is relative to the corner of the target; `viewport` is a corner and a
/// size in pixels.
pub fn ndc_of_fragment(frag_coord: Vec2, viewport: Vec4) -> Vec2 {
    let uv = (frag_coord - viewport.xy()) / viewport.zw();
    uv * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0)
}

/// Homogeneous view-space position of `p`. `view_from` transforms from the space of `p`, whose z is depth.
pub fn homogeneous_position(view_from: Mat4, p: Vec3) -> Vec4 {
    view_from * p.extend(1.0)
}

/// As [`homogeneous_position`], divided by w. `view_from` is `normalized` unless the projection is
/// [`ProjectionKind::Other`].
pub fn view_position(kind: ProjectionKind, view_from: Mat4, p: Vec3) -> Vec3 {
    let [x, y, z, w] = view_from.to_cols_array_2d();
    let scale = Vec2::new(x[0], y[1]);
    match kind {
        ProjectionKind::Perspective => {
            let ray = p.xy() * scale + Vec2::new(w[0], w[1]);
            ray.extend(w[2]) / (z[3] * p.z + w[3])
        }
        // Temporal jitter shears orthographic views.
        ProjectionKind::Orthographic => {
            (p.xy() * scale).extend(0.0)
                + p.z * Vec3::new(z[0], z[1], z[2])
                + Vec3::new(w[0], w[1], w[2])
        }
        ProjectionKind::Other => {
            let position = homogeneous_position(view_from, p);
            position.xyz() / position.w
        }
    }
}
