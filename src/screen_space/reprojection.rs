//! Where the last frame had what this one shows.

use bevy::math::{DMat4, DVec3, Mat4, Vec4};

use super::succession::LastFrame;

/// From pixels of this frame's viewport and depth, and back: a pixel is 1 wide, the first one begins at 0, and y goes down.
fn pixel_from_view(frame: &LastFrame) -> DMat4 {
    let half = frame.viewport.size().as_dvec2() / 2.0;
    let pixel_from_ndc = DMat4::from_scale_rotation_translation(
        DVec3::new(half.x, -half.y, 1.0),
        Default::default(),
        half.extend(0.0),
    );
    pixel_from_ndc * frame.clip_from_view.as_dmat4()
}

/// From the view space of a frame to its pixels and depth, homogeneous.
pub(super) fn pixels_of(frame: &LastFrame) -> Mat4 {
    pixel_from_view(frame).as_mat4()
}

/// From the view space of a frame to that of the `last` one. With double precision: both cameras may be far from the world's
/// origin.
fn last_view_from_view(now: &LastFrame, last: &LastFrame) -> DMat4 {
    last.world_from_view.as_dmat4().inverse() * now.world_from_view.as_dmat4()
}

/// From the view space of a frame to pixels and depth of the `last` one, homogeneous.
pub(super) fn last_pixel_from_view(now: &LastFrame, last: &LastFrame) -> Mat4 {
    (pixel_from_view(last) * last_view_from_view(now, last)).as_mat4()
}

/// Whose dot product with a homogeneous position in the view space of a frame is the distance along the view direction of
/// the `last` one.
pub(super) fn last_distance(now: &LastFrame, last: &LastFrame) -> Vec4 {
    (-last_view_from_view(now, last).row(2)).as_vec4()
}

/// This frame's exposure over that of the last one; 0 without a last frame.
pub(super) fn exposure_ratio(now: &LastFrame, last: Option<&LastFrame>) -> f32 {
    let ratio = last.map_or(0.0, |last| now.exposure / last.exposure);
    if ratio.is_finite() { ratio } else { 0.0 }
}

/// `x` within 0 and `largest`; 0 for what is not a number.
pub(super) fn up_to(largest: f32, x: f32) -> f32 {
    if x > 0.0 { x.min(largest) } else { 0.0 }
}
