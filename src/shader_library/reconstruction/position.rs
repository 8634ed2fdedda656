//! The kinds of projection with a cheaper form of `position.wgsl`, and the matrices and sizes that shaders read.

use bevy::math::{Mat4, UVec2, Vec2, Vec3};

/// Kinds of projection; positions are cheaper to compute for the first two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ProjectionKind {
    /// Any perspective projection, including off-centre ones and those with a far plane.
    Perspective,
    /// Any orthographic projection, including off-centre ones and those with temporal jitter.
    Orthographic,
    /// Any other projection, such as with an oblique near plane.
    Other,
}

impl ProjectionKind {
    /// Shader def that `position.wgsl` is compiled with.
    pub fn shader_def(self) -> Option<&'static str> {
        match self {
            Self::Perspective => Some("PROJECTION_PERSPECTIVE"),
            Self::Orthographic => Some("PROJECTION_ORTHOGRAPHIC"),
            Self::Other => None,
        }
    }

    /// True if shaders that are compiled for this kind are correct for `other` too. Those for [`ProjectionKind::Other`] assume that rays
    /// start at the camera, as in perspective.
    pub(crate) fn covers(self, other: Self) -> bool {
        self == other || (self, other) == (Self::Other, Self::Perspective)
    }
}

/// Kind of the projection `clip_from_view`.
pub fn projection_of(clip_from_view: Mat4) -> ProjectionKind {
    let [x, y, z, w] = clip_from_view.to_cols_array_2d();
    let independent = x[1..] == [0.0; 3] && [y[0], y[2], y[3]] == [0.0; 3];
    match [z[3], w[3]] {
        [-1.0, 0.0] if independent && w[..2] == [0.0; 2] => ProjectionKind::Perspective,
        [0.0, 1.0] if independent && z[..2] == [0.0; 2] => ProjectionKind::Orthographic,
        _ => ProjectionKind::Other,
    }
}

/// True for perspective projections without a far plane: the depth of surfaces approaches 0 but never reaches it.
pub fn depth_of_surfaces_is_above_zero(clip_from_view: Mat4) -> bool {
    projection_of(clip_from_view) == ProjectionKind::Perspective
        && clip_from_view.z_axis.z == 0.0
        && clip_from_view.w_axis.z > 0.0
}

/// `clip_from_view` and `world_from_view` of the same view, in a view space in metres: removes the scale that a camera inherits from
/// its ancestors. Shear, from rotated ancestors, is dropped. Cameras without scale are returned unchanged.
pub fn without_scale(clip_from_view: Mat4, world_from_view: Mat4) -> (Mat4, Mat4) {
    let (scale, rotation, translation) = world_from_view.to_scale_rotation_translation();
    let is_scaled = (scale - Vec3::ONE).abs().max_element() > 1e-5;
    // False for NaN as well.
    let is_regular = scale.abs().min_element() > 0.0 && scale.is_finite();
    if !(is_scaled && is_regular) {
        return (clip_from_view, world_from_view);
    }
    let mut clip = clip_from_view * Mat4::from_scale(scale.recip());
    if clip_from_view.z_axis.w != 0.0 {
        // Any multiple is the same projection; this is the one whose kind is recognised.
        clip *= scale.z;
        clip.z_axis.w = clip_from_view.z_axis.w;
    }
    let world = Mat4::from_rotation_translation(rotation, translation);
    (clip, world)
}

/// Scales the matrix for the short cuts of `view_position` in shaders: rays end at z = -1 in perspective, and w is 1 in orthographic views.
pub fn normalized(view_from: Mat4) -> Mat4 {
    let w = view_from.w_axis;
    if view_from.z_axis.w == 0.0 && w.w != 0.0 {
        view_from * (1.0 / w.w)
    } else if w.z != 0.0 {
        view_from * (1.0 / w.z.abs())
    } else {
        view_from
    }
}

/// From pixels of a viewport of this size, and depth, to view space; homogeneous and [`normalized`].
pub fn view_from_pixel(clip_from_view: Mat4, viewport_size: UVec2) -> Mat4 {
    let size = viewport_size.as_vec2();
    let ndc_from_pixel = Mat4::from_translation(Vec3::new(-1.0, 1.0, 0.0))
        * Mat4::from_scale(Vec3::new(2.0 / size.x, -2.0 / size.y, 1.0));
    normalized(clip_from_view.inverse() * ndc_from_pixel)
}

/// Pixels per unit of `ray_at`, for a matrix from [`view_from_pixel`]. Meaningless for [`ProjectionKind::Other`].
pub fn pixels_per_ray(view_from_pixel: Mat4) -> Vec2 {
    Vec2::new(view_from_pixel.x_axis.x, view_from_pixel.y_axis.y).recip()
}

/// Pixels per metre at a distance of one metre; in orthographic views at any distance. Negative along axes that the projection
/// mirrors.
pub fn pixels_per_metre(clip_from_view: Mat4, viewport_size: UVec2) -> Vec2 {
    // The matrix is homogeneous: any multiple of it is the same projection.
    let w = if clip_from_view.z_axis.w == 0.0 {
        clip_from_view.w_axis.w
    } else {
        -clip_from_view.z_axis.w
    };
    let scale = Vec2::new(clip_from_view.x_axis.x, clip_from_view.y_axis.y) / w;
    scale * viewport_size.as_vec2() / 2.0
}

/// Slope of the steepest surface, in pixels of depth per pixel across: 83 degrees away from facing the viewer.
pub const STEEPEST: f32 = 8.0;

/// x and y such that `x * depth + y` is the depth step that separates the surfaces of neighbouring pixels: steeper than
/// [`STEEPEST`].
pub fn edge_of(clip_from_view: Mat4, viewport_size: UVec2) -> Vec2 {
    let step = STEEPEST / pixels_per_metre(clip_from_view, viewport_size).y.abs();
    if projection_of(clip_from_view) == ProjectionKind::Orthographic {
        Vec2::new(0.0, step * clip_from_view.z_axis.z.abs())
    } else {
        // Depth minus this constant is inverse to distance, and the width of a pixel in metres is proportional to distance.
        let constant = -clip_from_view.z_axis.z;
        Vec2::new(step, -step * constant)
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Quat;

    use super::*;

    #[test]
    fn what_is_scaled_is_seen_where_it_was() {
        let perspective = Mat4::perspective_infinite_reverse_rh(0.9, 1.5, 0.1);
        let orthographic = Mat4::orthographic_rh(-3.0, 3.0, -2.0, 2.0, 50.0, 0.0);
        let turn = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.3, -1.1, 0.4);
        let place = Vec3::new(4.0, -2.0, 7.0);
        for clip_from_view in [perspective, orthographic] {
            for scale in [
                Vec3::splat(3.0),
                Vec3::splat(0.01),
                Vec3::new(-2.0, 0.5, 1.5),
            ] {
                let world_from_view = Mat4::from_scale_rotation_translation(scale, turn, place);
                let (clip, world) = without_scale(clip_from_view, world_from_view);
                assert_eq!(projection_of(clip), projection_of(clip_from_view));
                assert!((world.determinant() - 1.0).abs() < 1e-5);
                for at in [Vec3::new(0.4, 0.3, -2.0), Vec3::new(-1.0, 0.6, -9.0)] {
                    let there = world_from_view.as_dmat4().transform_point3(at.as_dvec3());
                    let in_view = world.as_dmat4().inverse().transform_point3(there);
                    let seen = clip_from_view.as_dmat4().project_point3(at.as_dvec3());
                    let found = clip.as_dmat4().project_point3(in_view);
                    assert!(seen.abs_diff_eq(found, 1e-5), "{seen} and {found}");
                }
            }
            let rigid = Mat4::from_rotation_translation(turn, place);
            assert_eq!(
                without_scale(clip_from_view, rigid),
                (clip_from_view, rigid)
            );
        }
    }
}
