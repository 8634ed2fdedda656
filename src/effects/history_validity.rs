//! Detects if the frames of a view directly follow one another, so that the history of one is valid in the next.

use core::sync::atomic::{AtomicU64, Ordering};

use bevy::{
    camera::MainPassResolutionOverride,
    math::DVec3,
    prelude::*,
    render::{Render, RenderApp, RenderSystems, view::ExtractedView},
};

use super::world_shift::{self, WorldShift};
use crate::{
    shader_library::reconstruction::position::{ProjectionKind, projection_of, without_scale},
    view::CameraCuts,
};

/// Camera state of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastFrame {
    /// Without the jitter of `TemporalJitter`, which Bevy adds to its own uniforms only: a picture may be displaced by up to half
    /// a pixel.
    pub clip_from_view: Mat4,
    /// Without the scale of the camera: view space is in metres.
    pub world_from_view: Mat4,
    /// The part of the target that was drawn, in pixels. It may differ from frame to frame.
    pub viewport: URect,
    /// Factor from light to the values in the picture.
    pub exposure: f32,
    /// Sum of the world shifts up to that frame, in metres.
    pub world_shift: DVec3,
}

/// The part of the target that is drawn, in pixels.
pub(super) fn drawn_part(
    view: &ExtractedView,
    resolution: Option<&MainPassResolutionOverride>,
) -> URect {
    let corner = view.viewport.xy();
    let size = resolution.map_or(view.viewport.zw(), |resolution| resolution.0);
    URect::from_corners(corner, corner + size)
}

impl LastFrame {
    /// State of a view in the frame that is being prepared.
    pub(super) fn of(
        view: &ExtractedView,
        resolution: Option<&MainPassResolutionOverride>,
        exposure: f32,
        shift: &WorldShift,
    ) -> Self {
        let (clip_from_view, world_from_view) =
            without_scale(view.clip_from_view, view.world_from_view.to_matrix());
        Self {
            clip_from_view,
            world_from_view,
            viewport: drawn_part(view, resolution),
            exposure,
            world_shift: shift.0,
        }
    }

    /// True if rays are parallel, and do not start at the camera.
    pub(super) fn is_orthographic(&self) -> bool {
        projection_of(self.clip_from_view) == ProjectionKind::Orthographic
    }

    /// True if both projections are orthographic, or none is. Viewports may differ: pictures are mapped by those of their frames.
    fn is_like(&self, other: &Self) -> bool {
        self.is_orthographic() == other.is_orthographic()
    }
}

/// Number of the current frame.
#[derive(Resource, Default)]
pub(super) struct FrameNumber(pub(super) u64);

fn count_frames(mut number: ResMut<FrameNumber>) {
    number.0 += 1;
}

/// Counts frames and detects shifts of the world. Added once, by the effects that compare frames.
pub(super) struct HistoryValidityPlugin;

impl HistoryValidityPlugin {
    pub(super) fn add_to(app: &mut App) {
        if !app.is_plugin_added::<Self>() {
            app.add_plugins(Self);
        }
    }
}

impl Plugin for HistoryValidityPlugin {
    fn build(&self, app: &mut App) {
        world_shift::add_to(app);
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app
                .init_resource::<FrameNumber>()
                .add_systems(Render, count_frames.in_set(RenderSystems::PrepareAssets));
        }
    }
}

/// The frames of one view.
pub(super) struct HistoryValidity {
    last: Option<LastFrame>,
    current: LastFrame,
    cuts: u32,
    /// Number of the last frame whose history was kept.
    held: AtomicU64,
}

impl HistoryValidity {
    pub(super) fn new(current: LastFrame, cuts: Option<&CameraCuts>) -> Self {
        Self {
            last: None,
            current,
            cuts: cuts.copied().unwrap_or_default().0,
            held: AtomicU64::new(0),
        }
    }

    /// Advances to the frame `number`. Call it in each frame.
    pub(super) fn advance(
        &mut self,
        current: LastFrame,
        cuts: Option<&CameraCuts>,
        number: &FrameNumber,
    ) {
        let cuts = cuts.copied().unwrap_or_default().0;
        let follows = *self.held.get_mut() + 1 == number.0
            && self.cuts == cuts
            && self.current.is_like(&current);
        self.last = follows.then_some(self.current);
        self.current = current;
        self.cuts = cuts;
    }

    /// Camera state of the last frame; `None` if its history is invalid.
    pub(super) fn last(&self) -> Option<&LastFrame> {
        self.last.as_ref()
    }

    /// Records that the history of this frame was kept.
    pub(super) fn hold(&self, number: &FrameNumber) {
        self.held.store(number.0, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parallel_rays_are_unlike_others() {
        let perspective = Mat4::perspective_infinite_reverse_rh(0.9, 1.5, 0.1);
        let mut oblique = perspective;
        oblique.x_axis.z = 0.2;
        let orthographic = Mat4::orthographic_rh(-3.0, 3.0, -2.0, 2.0, 50.0, 0.0);
        let [perspective, oblique, orthographic] =
            [perspective, oblique, orthographic].map(|clip_from_view| LastFrame {
                clip_from_view,
                world_from_view: Mat4::IDENTITY,
                viewport: URect::new(0, 0, 64, 48),
                exposure: 1.0,
                world_shift: DVec3::ZERO,
            });
        assert!(perspective.is_like(&oblique));
        assert!(!perspective.is_like(&orthographic));
        let resized = LastFrame {
            viewport: URect::new(8, 4, 60, 40),
            ..perspective
        };
        assert!(perspective.is_like(&resized));
    }
}
