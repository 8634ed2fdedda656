//! What cameras need, for effects of their own and for those of other cameras of their target.

use bevy::{ecs::component::ComponentId, prelude::*};

/// What a camera needs.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Need {
    WithoutMsaa,
    Hdr,
    /// A main texture apart from those of cameras that are alike only since they were changed. No effect needs it for its
    /// own camera.
    OwnTexture,
}

/// An effect that a camera must fit.
pub(crate) trait CameraEffect: Component {
    const NEEDS: &'static [Need];
}

/// What each of the effects that were added needs.
#[derive(Resource, Default)]
pub(crate) struct CameraNeeds(Vec<(ComponentId, &'static [Need])>);

impl CameraNeeds {
    pub(super) fn add(&mut self, effect: ComponentId, needs: &'static [Need]) {
        self.0.push((effect, needs));
    }

    /// Whether some effect on `camera` needs it.
    pub(super) fn has(&self, camera: EntityRef, need: Need) -> bool {
        (self.0.iter()).any(|(effect, needs)| camera.contains_id(*effect) && needs.contains(&need))
    }
}

/// On a camera: what effects of other cameras need of it.
#[derive(Component, Default)]
pub(crate) struct PartnerNeeds(pub(super) Vec<Need>);

/// Whether some effect of this crate on `camera`, or on a partner, needs it.
pub(super) fn is_needed(camera: &EntityWorldMut, need: Need) -> bool {
    let needs = camera.world().resource::<CameraNeeds>();
    needs.has(camera.as_readonly(), need)
        || camera
            .get::<PartnerNeeds>()
            .is_some_and(|needs| needs.0.contains(&need))
}
