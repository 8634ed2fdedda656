//! Cosine-weighted occlusion of the hemisphere by a pair of horizons.

use core::f32::consts::{FRAC_PI_2, PI};

use bevy::math::{Vec2, Vec3};

/// Area between an arc of the unit circle and its chord at distance `c`, in -1..1, from the centre: `acos(c) - c * sqrt(1 - c * c)`.
/// The error is at most 6.3e-6; the cubic minimises the largest error.
pub fn segment(c: f32) -> f32 {
    let a = c.abs();
    let t = (1.0 - a).max(0.0);
    let polynomial = ((0.0114644 * a - 0.0521626) * a + 0.3559525) * a + FRAC_PI_2;
    let area = polynomial * t * t.sqrt();
    if c >= 0.0 { area } else { PI - area }
}

/// A normal in the plane of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceNormal {
    /// Length of the normal's projection into the plane.
    pub length: f32,
    /// Cosine of its angle to the viewer.
    pub cosine: f32,
    /// Sine of that angle, positive towards the slice's tangent.
    pub sine: f32,
}

/// Projects `normal` into the plane of the unit vectors `to_viewer` and `tangent`.
pub fn slice_normal(normal: Vec3, to_viewer: Vec3, tangent: Vec3) -> SliceNormal {
    let projected = Vec2::new(normal.dot(to_viewer), normal.dot(tangent));
    let size = projected.length();
    let unit = if size > 1e-6 {
        projected / size
    } else {
        Vec2::X
    };
    SliceNormal {
        length: size,
        cosine: unit.x,
        sine: unit.y,
    }
}

/// Cosine-weighted light of one side of a slice, between the viewer's direction and the angle whose cosine is `c`, in the closed form
/// of Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion", without its double angles. `side` is 1
/// or -1.
pub fn arc(normal: SliceNormal, c: f32, side: f32) -> f32 {
    let s_squared = (1.0 - c * c).max(0.0);
    0.5 * (s_squared * normal.cosine + side * segment(c) * normal.sine)
}

/// Part of the hemisphere about `normal` that lies on `side` between the horizon `c` and the tangent plane `base` of the surface.
/// Both are cosines of angles to the viewer. Exactly 0 where the horizon is the surface.
pub fn side_occlusion(normal: SliceNormal, base: f32, c: f32, side: f32) -> f32 {
    let lowest = base.max(-side * normal.sine);
    if c <= lowest {
        return 0.0;
    }
    normal.length * (arc(normal, lowest, side) - arc(normal, c, side)).max(0.0)
}
