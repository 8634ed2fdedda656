//! Reprojection from this frame to the last one.

use bevy::{
    math::{DMat4, DVec3, Mat4, Vec4},
    prelude::*,
    shader::load_shader_library,
};

use super::{history_validity::LastFrame, world_shift};

/// Loads `reprojection.wgsl`. Added once, by the effects that reproject light.
pub(super) struct ReprojectionPlugin;

impl ReprojectionPlugin {
    pub(super) fn add_to(app: &mut App) {
        if !app.is_plugin_added::<Self>() {
            app.add_plugins(Self);
        }
    }
}

impl Plugin for ReprojectionPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "reprojection.wgsl");
    }
}

/// From view space to pixels of the viewport and depth: a pixel is 1 wide, the first one begins at 0, and y points down.
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

/// From the view space of a frame to that of the `last` one. In double precision, since both cameras may be far from the world's
/// origin.
fn last_view_from_view(now: &LastFrame, last: &LastFrame) -> DMat4 {
    let shift_back = DMat4::from_translation(last.world_shift - now.world_shift);
    last.world_from_view.as_dmat4().inverse() * shift_back * now.world_from_view.as_dmat4()
}

/// From the view space of a frame to pixels and depth of the `last` one, homogeneous.
pub(super) fn last_pixel_from_view(now: &LastFrame, last: &LastFrame) -> Mat4 {
    (pixel_from_view(last) * last_view_from_view(now, last)).as_mat4()
}

/// Vector whose dot product with a homogeneous view-space position is its distance along the view direction of the `last` frame.
pub(super) fn last_distance(now: &LastFrame, last: &LastFrame) -> Vec4 {
    (-last_view_from_view(now, last).row(2)).as_vec4()
}

/// True if the camera moved since the `last` frame, so that surfaces may have moved with it, as a weapon does. Not if it moved so far
/// that it was set to another place.
pub(super) fn may_carry_surfaces(now: &LastFrame, last: &LastFrame) -> bool {
    let last_view_from_view = last_view_from_view(now, last);
    let moved = last_view_from_view.w_axis.truncate().length();
    // Above the rounding of products of matrices.
    !last_view_from_view.abs_diff_eq(DMat4::IDENTITY, 1e-7)
        && moved <= f64::from(world_shift::LEAST)
}

/// This frame's exposure divided by that of the last one; 0 without a last frame.
pub(super) fn exposure_ratio(now: &LastFrame, last: Option<&LastFrame>) -> f32 {
    let ratio = last.map_or(0.0, |last| now.exposure / last.exposure);
    if ratio.is_finite() { ratio } else { 0.0 }
}

/// Clamps `x` to 0..`largest`; NaN becomes 0.
pub(super) fn up_to(largest: f32, x: f32) -> f32 {
    if x > 0.0 { x.min(largest) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use bevy::math::{DVec2, URect};
    use proptest::prelude::*;

    use super::*;

    const SIZE: UVec2 = UVec2::new(1920, 1080);

    /// `off_center` shifts the projection, as those of a part of a larger picture or of an eye are.
    fn frame(
        camera: Vec3,
        turn: Quat,
        field_of_view: f32,
        off_center: [f32; 2],
        size: UVec2,
    ) -> LastFrame {
        let mut clip_from_view =
            Mat4::perspective_infinite_reverse_rh(field_of_view, 16.0 / 9.0, 0.1);
        clip_from_view.z_axis.x = off_center[0];
        clip_from_view.z_axis.y = off_center[1];
        LastFrame {
            clip_from_view,
            world_from_view: Mat4::from_rotation_translation(turn, camera),
            viewport: URect::from_corners(UVec2::new(7, 3), UVec2::new(7, 3) + size),
            exposure: 1.0,
            world_shift: DVec3::ZERO,
        }
    }

    /// Pixel of a frame that shows `world`, and its distance along the view direction.
    fn seen(frame: &LastFrame, world: DVec3) -> (DVec2, f64) {
        let view = frame
            .world_from_view
            .as_dmat4()
            .inverse()
            .transform_point3(world);
        let clip = frame.clip_from_view.as_dmat4() * view.extend(1.0);
        let ndc = clip.truncate().truncate() / clip.w;
        let uv = ndc * DVec2::new(0.5, -0.5) + 0.5;
        (uv * frame.viewport.size().as_dvec2(), -view.z)
    }

    fn vector(largest: f32) -> impl Strategy<Value = Vec3> {
        [-1.0..1.0f32, -1.0..1.0f32, -1.0..1.0f32].prop_map(move |v| largest * Vec3::from(v))
    }

    #[test]
    fn cameras_that_move_may_carry_surfaces() {
        let at = |x: f32, angle: f32| {
            frame(
                Vec3::X * x,
                Quat::from_rotation_y(angle),
                1.0,
                [0.0; 2],
                SIZE,
            )
        };
        let last = at(1.0, 0.2);
        assert!(!may_carry_surfaces(&last, &last), "at rest");
        assert!(may_carry_surfaces(&at(1.5, 0.2), &last), "a step");
        assert!(may_carry_surfaces(&at(1.0, 0.3), &last), "a turn");
        assert!(!may_carry_surfaces(&at(40.0, 0.2), &last), "a jump");
        // A shift of the world moves no camera.
        let shifted = LastFrame {
            world_shift: DVec3::X * 64.0,
            ..at(65.0, 0.2)
        };
        assert!(!may_carry_surfaces(&shifted, &last), "a shift of the world");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 4096, failure_persistence: None, ..ProptestConfig::default() })]

        /// Includes positions 20 km from the world's origin, where f32 has steps of 2 mm.
        #[test]
        fn what_is_seen_is_found_where_it_was_seen(
            origin in prop_oneof![Just(Vec3::ZERO), vector(20_000.0)],
            step in vector(2.0),
            turns in [vector(0.3), vector(0.3)],
            fields in [0.3..2.0f32, 0.3..2.0f32],
            off_center in [[-0.4..0.4f32, -0.4..0.4f32], [-0.4..0.4f32, -0.4..0.4f32]],
            // As in a window that is dragged.
            last_size in [500..1920u32, 300..1080u32],
            view in (-0.5..0.5f32, -0.5..0.5f32, 0.0..3.0f32),
            shift in prop_oneof![Just(Vec3::ZERO), vector(5_000.0)],
        ) {
            let turn = |v: Vec3| Quat::from_scaled_axis(v);
            let mut now = frame(origin + step + shift, turn(turns[0]), fields[0], off_center[0], SIZE);
            now.world_shift = shift.as_dvec3();
            let last = frame(origin, turn(turns[1]), fields[1], off_center[1], UVec2::from(last_size));
            let distance = 10f32.powf(view.2) * 4.0;
            let position = distance * Vec3::new(view.0, view.1, -1.0);
            let world = now.world_from_view.as_dmat4().transform_point3(position.as_dvec3());

            // The position before the world was shifted.
            let (pixel, far) = seen(&last, world - shift.as_dvec3());
            prop_assume!(far > 0.5);
            let found = last_pixel_from_view(&now, &last) * position.extend(1.0);
            let off = (DVec2::new(f64::from(found.x), f64::from(found.y)) / f64::from(found.w)).distance(pixel);
            // Grows with the distance from the viewport.
            let allowed = 2e-3 + 2e-6 * pixel.length();
            prop_assert!(off < allowed, "{off} pixels");
            let found = f64::from(last_distance(&now, &last).dot(position.extend(1.0)));
            prop_assert!((found - far).abs() < 1e-6 * far + 1e-5, "{found} and not {far} m");

            let own = pixels_of(&now) * position.extend(1.0);
            let off = (DVec2::new(f64::from(own.x), f64::from(own.y)) / f64::from(own.w)).distance(seen(&now, world).0);
            prop_assert!(off < 1e-2, "{off} pixels in its own frame");
        }
    }
}
