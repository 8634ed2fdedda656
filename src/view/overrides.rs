//! What the effects of this crate change about a camera, and give back: `Msaa`, which is switched off, and `Hdr`, which
//! is added.
//!
//! `#[require(Hdr)]` would not do: afterwards nothing tells whether the camera had it before.

use bevy::{
    camera::Hdr,
    ecs::{
        change_detection::{CheckChangeTicks, Tick},
        component::ComponentId,
    },
    prelude::*,
};

/// What an effect needs of its camera.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Need {
    WithoutMsaa,
    Hdr,
}

/// An effect that a camera must fit.
pub(crate) trait CameraEffect: Component {
    const NEEDS: &'static [Need];
}

/// What each of the effects that were added needs.
#[derive(Resource, Default)]
pub(crate) struct CameraNeeds(Vec<(ComponentId, &'static [Need])>);

/// Whether some effect of this crate on `camera` needs it.
fn is_needed(camera: &EntityWorldMut, need: Need) -> bool {
    let effects = &camera.world().resource::<CameraNeeds>().0;
    (effects.iter()).any(|(effect, needs)| camera.contains_id(*effect) && needs.contains(&need))
}

/// On a camera: what was changed about it, and when. What has changed again since is the app's own.
#[derive(Component, Default)]
pub(crate) struct CameraOverrides {
    /// What it had before it was switched off.
    msaa: Option<(Msaa, Tick)>,
    /// It was added.
    hdr: Option<Tick>,
}

impl CameraOverrides {
    fn switch_msaa_off(&mut self, camera: &mut EntityWorldMut) {
        if let Some(mut msaa) = camera.get_mut::<Msaa>()
            && *msaa != Msaa::Off
        {
            let before = *msaa;
            *msaa = Msaa::Off;
            self.msaa = Some((before, msaa.last_changed()));
        }
    }

    fn keep_on(self, camera: &mut EntityWorldMut) {
        if self.msaa.is_some() || self.hdr.is_some() {
            camera.insert(self);
        }
    }
}

/// Makes cameras fit the effect `E` when they get it, once, and gives back what they had when they lose it.
pub(crate) fn add_to<E: CameraEffect>(app: &mut App) {
    let effect = app.world_mut().register_component::<E>();
    let mut needs = app.world_mut().resource_mut::<CameraNeeds>();
    needs.0.push((effect, E::NEEDS));
    app.add_observer(override_camera::<E>)
        .add_observer(give_back::<E>);
}

/// For entities that have an effect before they are a camera.
pub(crate) fn override_new_camera(added: On<Add, Msaa>, mut commands: Commands) {
    let override_camera = |mut camera: EntityWorldMut| {
        if is_needed(&camera, Need::WithoutMsaa) {
            let mut overrides = camera.take::<CameraOverrides>().unwrap_or_default();
            overrides.switch_msaa_off(&mut camera);
            overrides.keep_on(&mut camera);
        }
    };
    commands
        .entity(added.entity)
        .queue_silenced(override_camera);
}

/// Ticks are compared with those of components, which Bevy keeps from growing too old.
pub(crate) fn keep_ticks_young(
    check: On<CheckChangeTicks>,
    mut cameras: Query<&mut CameraOverrides>,
) {
    for mut overrides in &mut cameras {
        let overrides = overrides.bypass_change_detection();
        let msaa = overrides.msaa.as_mut().map(|(_, tick)| tick);
        for tick in msaa.into_iter().chain(&mut overrides.hdr) {
            tick.check_tick(*check);
        }
    }
}

fn override_camera<E: CameraEffect>(added: On<Add, E>, mut commands: Commands) {
    let override_camera = |mut camera: EntityWorldMut| {
        let mut overrides = camera.take::<CameraOverrides>().unwrap_or_default();
        if E::NEEDS.contains(&Need::WithoutMsaa) {
            overrides.switch_msaa_off(&mut camera);
        }
        if E::NEEDS.contains(&Need::Hdr) && !camera.contains::<Hdr>() {
            camera.insert(Hdr);
            overrides.hdr = last_changed::<Hdr>(&camera);
        }
        overrides.keep_on(&mut camera);
    };
    commands
        .entity(added.entity)
        .queue_silenced(override_camera);
}

fn give_back<E: CameraEffect>(removed: On<Remove, E>, mut commands: Commands) {
    let give_back = |mut camera: EntityWorldMut| {
        let Some(mut overrides) = camera.take::<CameraOverrides>() else {
            return;
        };
        if !is_needed(&camera, Need::WithoutMsaa)
            && let Some((before, when)) = overrides.msaa.take()
            && last_changed::<Msaa>(&camera) == Some(when)
            // Two changes within one system have one tick.
            && camera.get() == Some(&Msaa::Off)
        {
            camera.insert(before);
        }
        if !is_needed(&camera, Need::Hdr)
            && let Some(when) = overrides.hdr.take()
            && last_changed::<Hdr>(&camera) == Some(when)
            && !something_requires_hdr(&camera)
        {
            camera.remove::<Hdr>();
        }
        overrides.keep_on(&mut camera);
    };
    commands.entity(removed.entity).queue_silenced(give_back);
}

fn last_changed<C: Component>(camera: &EntityWorldMut) -> Option<Tick> {
    Some(camera.get_change_ticks::<C>()?.changed)
}

/// Whether another component, such as Bevy's `Bloom`, was promised that `Hdr` is there.
fn something_requires_hdr(camera: &EntityWorldMut) -> bool {
    let components = camera.world().components();
    let Some(hdr) = components.component_id::<Hdr>() else {
        return false;
    };
    camera.archetype().components().iter().any(|id| {
        components
            .get_info(*id)
            .is_some_and(|info| info.required_components().iter_ids().any(|id| id == hdr))
    })
}
