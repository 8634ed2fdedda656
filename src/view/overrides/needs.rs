//! The settings that effects need of their camera.

use bevy::{camera::Hdr, ecs::component::ComponentId, prelude::*};

/// A setting that effects need of a camera.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Need {
    WithoutMsaa,
    Hdr,
}

impl Need {
    pub(super) fn is_met_by(self, camera: EntityRef) -> bool {
        match self {
            Self::WithoutMsaa => camera.get::<Msaa>().is_none_or(|msaa| *msaa == Msaa::Off),
            Self::Hdr => camera.contains::<Hdr>(),
        }
    }

    /// Lists the components by which a camera meets `needs`, for a warning.
    pub(super) fn list(needs: &[Self]) -> String {
        let names: Vec<&str> = (needs.iter())
            .map(|need| match need {
                Self::WithoutMsaa => "`Msaa::Off`",
                Self::Hdr => "`Hdr`",
            })
            .collect();
        names.join(" and ")
    }
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
    pub(super) name: &'static str,
    pub(super) effect: ComponentId,
    pub(super) needs: &'static [Need],
    /// True if the device of the main world can run the effect.
    pub(super) can_run: fn(&World) -> bool,
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

    /// Names of the effects on `camera` that need one of `needs`.
    pub(super) fn effects_of(&self, camera: EntityRef, needs: &[Need]) -> Vec<&'static str> {
        (self.0.iter())
            .filter(|effect| effect.of(camera).iter().any(|need| needs.contains(need)))
            .map(|effect| effect.name)
            .collect()
    }

    /// Needs of `effect` on any camera that has it.
    pub(super) fn of_effect(&self, effect: Option<ComponentId>) -> &'static [Need] {
        (self.0.iter())
            .find(|needs| needs.runs && Some(needs.effect) == effect)
            .map_or(&[], |needs| needs.needs)
    }
}

/// True if some effect of this crate on `camera` needs it.
pub(super) fn is_needed(camera: &EntityWorldMut, need: Need) -> bool {
    let needs = camera.world().resource::<CameraNeeds>();
    needs.has(camera.as_readonly(), need)
}
