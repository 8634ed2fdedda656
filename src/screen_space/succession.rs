//! Which frames of a view follow one another, so that what was kept of one says something of the next.

use core::sync::atomic::{AtomicU64, Ordering};

use bevy::{
    camera::MainPassResolutionOverride,
    math::DVec3,
    prelude::*,
    render::{Render, RenderApp, RenderSystems, view::ExtractedView},
};

use super::world_shift::{self, WorldShift};
use crate::{
    shader_library::reconstruction::position::{projection_of, without_scale},
    view::CameraCuts,
};

/// What a frame was seen with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastFrame {
    /// With the jitter that it had.
    pub clip_from_view: Mat4,
    /// Where the camera was, without its scale: view space is in metres.
    pub world_from_view: Mat4,
    /// The part of the target that was drawn: its corner and size in pixels.
    pub viewport: URect,
    /// The factor of light in the picture.
    pub exposure: f32,
    /// By how much the world has been shifted until then.
    pub world_shift: DVec3,
}

/// The part of the target that is drawn.
pub(super) fn drawn_part(
    view: &ExtractedView,
    resolution: Option<&MainPassResolutionOverride>,
) -> URect {
    let corner = view.viewport.xy();
    let size = resolution.map_or(view.viewport.zw(), |resolution| resolution.0);
    URect::from_corners(corner, corner + size)
}

impl LastFrame {
    /// That of a view in the frame that is being prepared.
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

    /// Whether `other` shows as much in the same way.
    fn is_like(&self, other: &Self) -> bool {
        self.viewport == other.viewport
            && projection_of(self.clip_from_view) == projection_of(other.clip_from_view)
    }
}

/// Counts frames.
#[derive(Resource, Default)]
pub(super) struct FrameNumber(pub(super) u64);

fn count_frames(mut number: ResMut<FrameNumber>) {
    number.0 += 1;
}

/// Counts frames, and notices shifts of the world between them. Added by all that compare frames, once.
pub(super) struct SuccessionPlugin;

impl SuccessionPlugin {
    pub(super) fn add_to(app: &mut App) {
        if !app.is_plugin_added::<Self>() {
            app.add_plugins(Self);
        }
    }
}

impl Plugin for SuccessionPlugin {
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
pub(super) struct Succession {
    last: Option<LastFrame>,
    current: LastFrame,
    cuts: u32,
    /// The frame of which something was kept.
    held: AtomicU64,
}

impl Succession {
    pub(super) fn new(current: LastFrame, cuts: Option<&CameraCuts>) -> Self {
        Self {
            last: None,
            current,
            cuts: cuts.copied().unwrap_or_default().0,
            held: AtomicU64::new(0),
        }
    }

    /// To be called in each frame, of which `number` is the number.
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

    /// What the last frame was seen with; `None` if what was kept of it says nothing of this one.
    pub(super) fn last(&self) -> Option<&LastFrame> {
        self.last.as_ref()
    }

    /// Something of this frame was kept.
    pub(super) fn hold(&self, number: &FrameNumber) {
        self.held.store(number.0, Ordering::Relaxed);
    }
}
