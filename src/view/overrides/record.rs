//! Records the changes that effects made to a camera.

use bevy::{
    camera::Hdr,
    ecs::{
        change_detection::{CheckChangeTicks, Tick},
        component::Components,
    },
    prelude::*,
};

use super::needs::{Need, is_needed};

/// On a camera: changes to its settings, with their ticks. A setting that changed again since belongs to the app.
#[derive(Component, Default)]
pub(crate) struct CameraOverrides {
    /// Value before it was set to `Off`.
    msaa: Option<(Msaa, Tick)>,
    /// `Some` if `Hdr` was added.
    hdr: Option<Tick>,
}

impl CameraOverrides {
    /// Applies `change` to `camera` and its record.
    pub(super) fn change(
        camera: &mut EntityWorldMut,
        change: impl FnOnce(&mut Self, &mut EntityWorldMut),
    ) {
        let mut overrides = camera.take::<Self>().unwrap_or_default();
        change(&mut overrides, camera);
        if overrides.msaa.is_some() || overrides.hdr.is_some() {
            camera.insert(overrides);
        }
    }

    /// Applies [`fit`](Self::fit) for each need. Returns those for which the camera was changed.
    pub(super) fn fit_all(&mut self, camera: &mut EntityWorldMut, needs: &[Need]) -> Vec<Need> {
        let mut changed = needs.to_vec();
        changed.retain(|need| self.fit(camera, *need));
        changed
    }

    /// Changes the camera to meet `need`. Returns false if it already did.
    pub(super) fn fit(&mut self, camera: &mut EntityWorldMut, need: Need) -> bool {
        match need {
            Need::WithoutMsaa => {
                if let Some(mut msaa) = camera.get_mut::<Msaa>()
                    && *msaa != Msaa::Off
                {
                    let before = *msaa;
                    *msaa = Msaa::Off;
                    self.msaa = Some((before, msaa.last_changed()));
                    return true;
                }
            }
            Need::Hdr => {
                if !camera.contains::<Hdr>() {
                    camera.insert(Hdr);
                    self.hdr = last_changed::<Hdr>(camera.as_readonly());
                    return true;
                }
            }
        }
        false
    }

    /// Reverts changes that nothing needs any more.
    pub(super) fn give_back(&mut self, camera: &mut EntityWorldMut) {
        if !is_needed(camera, Need::WithoutMsaa) {
            let before = self.msaa_before(camera.as_readonly());
            self.msaa = None;
            if let Some(before) = before {
                camera.insert(before);
            }
        }
        if !is_needed(camera, Need::Hdr) {
            let was_added = self.has_added_hdr(camera.as_readonly());
            self.hdr = None;
            if was_added
                && !something_requires_hdr(camera.as_readonly(), camera.world().components())
            {
                camera.remove::<Hdr>();
            }
        }
    }

    /// True if `camera` was changed to meet `need` and the app has not changed that setting since.
    pub(super) fn holds(&self, camera: EntityRef, need: Need) -> bool {
        match need {
            Need::WithoutMsaa => self.msaa_before(camera).is_some(),
            Need::Hdr => self.has_added_hdr(camera),
        }
    }

    fn msaa_before(&self, camera: EntityRef) -> Option<Msaa> {
        let (before, when) = self.msaa?;
        let is_untouched = last_changed::<Msaa>(camera) == Some(when)
            // Two changes within one system have the same tick.
            && camera.get() == Some(&Msaa::Off);
        is_untouched.then_some(before)
    }

    fn has_added_hdr(&self, camera: EntityRef) -> bool {
        self.hdr.is_some() && last_changed::<Hdr>(camera) == self.hdr
    }
}

/// Keeps recorded ticks comparable with those of components, which Bevy keeps from growing too old.
pub(crate) fn keep_ticks_young(
    check: On<CheckChangeTicks>,
    mut cameras: Query<&mut CameraOverrides>,
) {
    for mut overrides in &mut cameras {
        let CameraOverrides { msaa, hdr } = overrides.bypass_change_detection();
        let msaa = msaa.as_mut().map(|(_, tick)| tick);
        for tick in msaa.into_iter().chain(hdr) {
            tick.check_tick(*check);
        }
    }
}

fn last_changed<C: Component>(camera: EntityRef) -> Option<Tick> {
    Some(camera.get_change_ticks::<C>()?.changed)
}

/// True if another component, such as Bevy's `Bloom`, requires `Hdr`.
fn something_requires_hdr(camera: EntityRef, components: &Components) -> bool {
    let Some(hdr) = components.component_id::<Hdr>() else {
        return false;
    };
    camera.archetype().components().iter().any(|id| {
        components
            .get_info(*id)
            .is_some_and(|info| info.required_components().iter_ids().any(|id| id == hdr))
    })
}
