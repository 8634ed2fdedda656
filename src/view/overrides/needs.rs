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
    const NAME: &'static str;
    const NEEDS: &'static [Need];
}

/// What each of the effects that were added needs, on devices that can run it.
#[derive(Resource, Default)]
pub(crate) struct CameraNeeds(pub(super) Vec<EffectNeeds>);

pub(super) struct EffectNeeds {
    pub(super) effect: ComponentId,
    pub(super) needs: &'static [Need],
    /// Tells the main world what its device can do for the effect; true if it can run it.
    pub(super) look_at_device: fn(&mut World) -> bool,
    /// False until there is a device.
    pub(super) runs: bool,
}

impl EffectNeeds {
    /// What `camera` needs for this effect.
    pub(super) fn of(&self, camera: EntityRef) -> &'static [Need] {
        if self.runs && camera.contains_id(self.effect) {
            self.needs
        } else {
            &[]
        }
    }
}

impl CameraNeeds {
    /// Whether some effect on `camera` needs it.
    pub(super) fn has(&self, camera: EntityRef, need: Need) -> bool {
        (self.0.iter()).any(|effect| effect.of(camera).contains(&need))
    }

    /// What `effect` needs of a camera that has it.
    pub(super) fn of_effect(&self, effect: Option<ComponentId>) -> &'static [Need] {
        (self.0.iter())
            .find(|needs| needs.runs && Some(needs.effect) == effect)
            .map_or(&[], |needs| needs.needs)
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
