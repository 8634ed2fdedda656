//! Tells cameras in the main world what they are doing.

use alloc::sync::Arc;

use bevy::{
    prelude::*,
    render::{
        MainWorld,
        sync_world::{MainEntity, MainEntityHashMap},
    },
};

use crate::view::{LeanDeferred, LeanOffReason, LeanStatus, warn_once::WarnOnce};

const EFFECT: &str = "LeanDeferred";

/// In the render world: what was decided for each camera in this frame.
#[derive(Resource, Default)]
pub(super) struct LeanStatuses {
    statuses: MainEntityHashMap<LeanStatus>,
    warnings: WarnOnce<LeanOffReason>,
}

impl LeanStatuses {
    pub(super) fn off(&mut self, camera: MainEntity, reason: LeanOffReason) {
        let warning = reason.is_of_camera().then(|| reason.clone());
        self.warnings.tell(EFFECT, camera, warning);
        self.statuses.insert(camera, LeanStatus::Off(reason));
    }

    /// A camera that nothing speaks against; `failure` is the cause why a pipeline that it waits for does not compile.
    pub(super) fn on(&mut self, camera: MainEntity, is_active: bool, failure: Option<Arc<str>>) {
        self.warnings.tell(EFFECT, camera, None);
        let status = match (is_active, failure) {
            (true, _) => LeanStatus::Lean,
            (false, None) => LeanStatus::Compiling,
            (false, Some(cause)) => LeanStatus::Off(LeanOffReason::Shader(cause.to_string())),
        };
        self.statuses.insert(camera, status);
    }
}

/// Hands what was decided for the last frame to the cameras in the main world.
pub(super) fn report_statuses(
    mut main_world: ResMut<MainWorld>,
    mut statuses: ResMut<LeanStatuses>,
    cameras: Query<&MainEntity, With<LeanDeferred>>,
) {
    for camera in &cameras {
        let status = statuses.statuses.remove(camera).unwrap_or_default();
        if let Some(mut reported) = main_world.get_mut::<LeanStatus>(camera.id()) {
            reported.set_if_neq(status);
        }
    }
    statuses.statuses.clear();
    statuses.warnings.keep_only(cameras.iter());
}

pub(super) fn remove_status(removed: On<Remove, LeanDeferred>, mut commands: Commands) {
    commands
        .entity(removed.entity)
        .queue_silenced(|mut camera: EntityWorldMut| {
            camera.remove::<LeanStatus>();
        });
}
