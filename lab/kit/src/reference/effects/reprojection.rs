//! Twin of `effects/reprojection.wgsl`.

use bevy::math::{Vec2, Vec4};

/// Weight with which a surface shown at `kept` is the one expected `at_rest`, `with_view`, or between the two.
pub fn weight_of_match(kept: f32, at_rest: f32, with_view: f32, tolerance: f32) -> f32 {
    let below = at_rest.min(with_view) - kept;
    let above = kept - at_rest.max(with_view);
    (2.0 - below.max(above).max(0.0) / tolerance.max(1e-30)).clamp(0.0, 1.0)
}

/// Pixels by which a surface moved on its own.
pub fn own_motion(at: Vec2, at_rest: Vec2, with_view: Vec2) -> f32 {
    at.distance(at_rest).min(at.distance(with_view))
}

/// `light`, with that of `other` in the share that is unknown.
pub fn filled_up(light: Vec4, other: Vec4) -> Vec4 {
    let share = (1.0 - light.w) * other.w;
    let known = light.w + share;
    let sum = light.truncate() * light.w + other.truncate() * share;
    (sum / known.max(1e-6)).extend(known)
}
