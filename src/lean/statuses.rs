//! Reports the status of cameras to the main world.

use core::mem::{discriminant, replace};

use bevy::{
    prelude::*,
    render::{
        MainWorld,
        sync_world::{MainEntity, MainEntityHashMap},
    },
};

use crate::view::{LeanDeferred, LeanOffReason, LeanStatus, warn_once::WarnOnce};

const EFFECT: &str = "LeanDeferred";

/// In the render world: the status of each camera. It is kept between frames, so that an unchanged status allocates
/// nothing.
#[derive(Resource, Default)]
pub(super) struct LeanStatuses {
    statuses: MainEntityHashMap<Decided>,
    warnings: WarnOnce<LeanOffReason>,
}

struct Decided {
    status: LeanStatus,
    in_this_frame: bool,
}

impl LeanStatuses {
    pub(super) fn off(&mut self, camera: MainEntity, reason: LeanOffReason) {
        let warning = reason.is_of_camera().then(|| reason.clone());
        self.warnings.tell(EFFECT, camera, warning);
        self.decide(camera, LeanStatus::Off(reason));
    }

    /// Like [`off`](Self::off), for a reason that is not logged per camera.
    pub(super) fn off_for(
        &mut self,
        camera: MainEntity,
        reason: fn(String) -> LeanOffReason,
        text: &str,
    ) {
        self.warnings.tell(EFFECT, camera, None);
        if let Some(known) = self.statuses.get_mut(&camera)
            && let LeanStatus::Off(known_reason) = &known.status
            && known_reason.text() == Some(text)
            && discriminant(known_reason) == discriminant(&reason(String::new()))
        {
            known.in_this_frame = true;
            return;
        }
        self.decide(camera, LeanStatus::Off(reason(text.into())));
    }

    /// Sets the status of a camera that may be lean. `failure` is the reason that a pipeline which it waits for does
    /// not compile.
    pub(super) fn on(&mut self, camera: MainEntity, is_active: bool, failure: Option<&str>) {
        match (is_active, failure) {
            (false, Some(cause)) => self.off_for(camera, LeanOffReason::Shader, cause),
            (is_active, _) => {
                self.warnings.tell(EFFECT, camera, None);
                let status = match is_active {
                    true => LeanStatus::Lean,
                    false => LeanStatus::Compiling,
                };
                self.decide(camera, status);
            }
        }
    }

    fn decide(&mut self, camera: MainEntity, status: LeanStatus) {
        let decided = Decided {
            status,
            in_this_frame: true,
        };
        self.statuses.insert(camera, decided);
    }
}

/// Copies the statuses of the last frame to the cameras in the main world.
pub(super) fn report_statuses(
    mut main_world: ResMut<MainWorld>,
    mut statuses: ResMut<LeanStatuses>,
    cameras: Query<&MainEntity, With<LeanDeferred>>,
) {
    statuses
        .statuses
        .retain(|_, decided| replace(&mut decided.in_this_frame, false));
    for camera in &cameras {
        let Some(mut reported) = main_world.get_mut::<LeanStatus>(camera.id()) else {
            continue;
        };
        match statuses.statuses.get(camera) {
            Some(decided) if decided.status == *reported => {}
            Some(decided) => *reported = decided.status.clone(),
            None => {
                reported.set_if_neq(LeanStatus::default());
            }
        }
    }
    statuses.warnings.keep_only(cameras.iter());
}

pub(super) fn remove_status(removed: On<Remove, LeanDeferred>, mut commands: Commands) {
    commands
        .entity(removed.entity)
        .queue_silenced(|mut camera: EntityWorldMut| {
            camera.remove::<LeanStatus>();
        });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_that_is_no_news_is_not_copied() {
        let mut statuses = LeanStatuses::default();
        let camera = MainEntity::from(Entity::from_raw_u32(1).unwrap());
        let mut text = |reason: fn(String) -> LeanOffReason, text: &str| {
            statuses.off_for(camera, reason, text);
            let decided = &statuses.statuses[&camera];
            assert!(decided.in_this_frame);
            let LeanStatus::Off(reason) = &decided.status else {
                panic!("{:?}", decided.status);
            };
            let text = reason.text().expect("it has one");
            (text.as_ptr(), decided.status.clone())
        };
        let (first, _) = text(LeanOffReason::Device, "compute shaders");
        let (second, status) = text(LeanOffReason::Device, "compute shaders");
        assert_eq!(first, second);
        let device = LeanOffReason::Device("compute shaders".into());
        assert_eq!(status, LeanStatus::Off(device));
        let (_, status) = text(LeanOffReason::Shader, "compute shaders");
        let shader = LeanOffReason::Shader("compute shaders".into());
        assert_eq!(status, LeanStatus::Off(shader));
    }
}
