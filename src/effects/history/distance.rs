//! Unit of the distances in the history, scaled so that half floats, which end at 65504, can hold all of them.

use bevy::math::{DMat4, DVec4, Mat4};

use crate::shader_library::reconstruction::position::{ProjectionKind, projection_of};

/// Smallest half float of full precision.
const SMALLEST: f64 = 1.0 / 16384.0;
/// Largest distance that differs from the sky's, with headroom.
const LARGEST: f64 = 65000.0;

/// Units per metre in frames with this projection. A power of two, so that scaling does not round, and at most 1. In perspective, the
/// near plane has about the smallest distance of full precision, and 10⁹ times its distance the largest.
pub(in crate::effects) fn units_per_metre(clip_from_view: Mat4) -> f32 {
    let view_from_clip = clip_from_view.as_dmat4().inverse();
    let [near, far] = [1.0, 0.0].map(|depth| distance_at(view_from_clip, depth));
    let exponent = if projection_of(clip_from_view) == ProjectionKind::Orthographic {
        (LARGEST / near.max(far)).log2().floor()
    } else {
        (SMALLEST / near).log2().ceil()
    };
    // False for NaN as well.
    if exponent > -100.0 && exponent < 0.0 {
        exponent.exp2() as f32
    } else {
        1.0
    }
}

/// Distance of this depth in the middle of the view.
fn distance_at(view_from_clip: DMat4, depth: f64) -> f64 {
    let position = view_from_clip * DVec4::new(0.0, 0.0, depth, 1.0);
    (position.z / position.w).abs()
}

#[cfg(test)]
mod tests {
    use bevy::camera::{CameraProjection, OrthographicProjection, PerspectiveProjection};
    use half::f16;

    use super::*;

    /// A distance after a round trip through the history, in metres.
    fn kept(clip_from_view: Mat4, metres: f32) -> f32 {
        let units = units_per_metre(clip_from_view);
        f16::from_f32(metres * units).to_f32() / units
    }

    #[test]
    fn distances_are_kept_in_any_unit() {
        for near in [1e-3, 0.1, 10.0, 1e4] {
            let projection = PerspectiveProjection {
                near,
                ..Default::default()
            };
            let clip_from_view = projection.get_clip_from_view();
            for times in [1.0, 3.3, 1e3, 1e6, 5e8] {
                let metres = near * times;
                let off = kept(clip_from_view, metres) / metres - 1.0;
                assert!(off.abs() < 1.0 / 2048.0, "{metres} from {near}: {off}");
            }
        }
        for far in [1e3, 1e5, 1e7] {
            let projection = OrthographicProjection {
                near: -far,
                far,
                ..OrthographicProjection::default_3d()
            };
            let clip_from_view = projection.get_clip_from_view();
            for share in [-1.0, -0.1, 0.01, 0.5, 1.0] {
                let metres = far * share;
                let off = kept(clip_from_view, metres) / metres - 1.0;
                assert!(off.abs() < 1.0 / 2048.0, "{metres} of {far}: {off}");
            }
        }
    }

    /// Powers of two scale distances without rounding.
    #[test]
    fn units_are_powers_of_two() {
        for near in [1e-5, 0.1, 0.7, 100.0, f32::NAN, 0.0] {
            let projection = PerspectiveProjection {
                near,
                ..Default::default()
            };
            let units = units_per_metre(projection.get_clip_from_view());
            assert!(units > 0.0 && units <= 1.0, "{near}");
            assert_eq!(units.log2().fract(), 0.0, "{near}");
        }
    }
}
