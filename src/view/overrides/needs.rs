//! The needs of cameras, for their own effects and for those of other cameras of their target.

use bevy::{ecs::component::ComponentId, prelude::*};

/// A setting that effects need of a camera.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Need {
    WithoutMsaa,
    Hdr,
    /// A main texture of its own, not shared with cameras whose settings are equal only since they were changed. No
    /// effect needs it for its own camera.
    OwnTexture,
}

/// An effect with needs that its camera must meet.
pub(crate) trait CameraEffect: Component {
    const NAME: &'static str;
    const NEEDS: &'static [Need];
}

/// The needs of each effect that was added, on devices that can run it.
#[derive(Resource, Default)]
pub(crate) struct CameraNeeds(pub(super) Vec<EffectNeeds>);

pub(super) struct EffectNeeds {
    pub(super) effect: ComponentId,
    pub(super) needs: &'static [Need],
    /// Inserts the effect's device support into the main world; true if the device can run the effect.
    pub(super) look_at_device: fn(&mut World) -> bool,
    /// True if the device can run the effect; false until there is a device.
    pub(super) runs: bool,
}

impl EffectNeeds {
    /// Needs of this effect on `camera`; none if the camera lacks the effect.
    pub(super) fn of(&self, camera: EntityRef) -> &'static [Need] {
        if self.runs && camera.contains_id(self.effect) {
            self.needs
        } else {
            &[]
        }
    }
}

impl CameraNeeds {
    /// True if some effect on `camera` needs it.
    pub(super) fn has(&self, camera: EntityRef, need: Need) -> bool {
        (self.0.iter()).any(|effect| effect.of(camera).contains(&need))
    }

    /// Needs of `effect` on any camera that has it.
    pub(super) fn of_effect(&self, effect: Option<ComponentId>) -> &'static [Need] {
        (self.0.iter())
            .find(|needs| needs.runs && Some(needs.effect) == effect)
            .map_or(&[], |needs| needs.needs)
    }
}

/// On a camera: needs of the effects of other cameras.
#[derive(Component, Default)]
pub(crate) struct PartnerNeeds(pub(super) Vec<Need>);

/// True if some effect of this crate on `camera`, or on a partner, needs it.
pub(super) fn is_needed(camera: &EntityWorldMut, need: Need) -> bool {
    let needs = camera.world().resource::<CameraNeeds>();
    needs.has(camera.as_readonly(), need)
        || camera
            .get::<PartnerNeeds>()
            .is_some_and(|needs| needs.0.contains(&need))
}
