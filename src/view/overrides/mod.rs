//! What the effects of this crate change about a camera, and give back: `Msaa`, which is switched off, and `Hdr`, which
//! is added.
//!
//! `#[require(Hdr)]` would not do: afterwards nothing tells whether the camera had it before.
//!
//! A device that cannot run an effect (`device.rs`) has nothing changed for it. Who changes a camera late is told so (`late.rs`).
//!
//! Cameras that were alike share their main texture and depth, and each is drawn over those before it. So that they still
//! do, the same is changed about the others (`partners.rs`).

mod device;
mod late;
mod needs;
mod partners;
mod record;

pub(crate) use device::fit_device;

pub(crate) use needs::{CameraEffect, CameraNeeds, Need};
pub(crate) use partners::{are_cameras_changed, fit_partners};
pub(crate) use record::keep_ticks_young;

use bevy::prelude::*;

use needs::{EffectNeeds, is_needed};
use record::CameraOverrides;

/// Makes cameras fit the effect `E` when they get it, once, and gives back what they had when they lose it. `look_at_device`
/// tells the main world what its device can do for the effect; where it returns false, cameras stay as they are.
pub(crate) fn add_to<E: CameraEffect>(app: &mut App, look_at_device: fn(&mut World) -> bool) {
    let effect = app.world_mut().register_component::<E>();
    let mut needs = app.world_mut().resource_mut::<CameraNeeds>();
    needs.0.push(EffectNeeds {
        effect,
        needs: E::NEEDS,
        look_at_device,
        runs: false,
    });
    app.add_observer(override_camera::<E>)
        .add_observer(give_back::<E>);
}

/// For entities that have an effect before they are a camera.
pub(crate) fn override_new_camera(added: On<Add, Msaa>, mut commands: Commands) {
    let override_camera = |mut camera: EntityWorldMut| {
        if is_needed(&camera, Need::WithoutMsaa) {
            CameraOverrides::change(&mut camera, |overrides, camera| {
                overrides.fit(camera, Need::WithoutMsaa);
            });
        }
    };
    commands
        .entity(added.entity)
        .queue_silenced(override_camera);
}

fn override_camera<E: CameraEffect>(added: On<Add, E>, mut commands: Commands) {
    let override_camera = |mut camera: EntityWorldMut| {
        let world = camera.world();
        let needs = world.resource::<CameraNeeds>();
        let needs = needs.of_effect(world.component_id::<E>());
        if !needs.is_empty() {
            CameraOverrides::change(&mut camera, |overrides, camera| {
                let changed = overrides.fit_all(camera, needs);
                late::warn_of_change::<E>(camera, &changed);
            });
        }
    };
    commands
        .entity(added.entity)
        .queue_silenced(override_camera);
}

fn give_back<E: CameraEffect>(removed: On<Remove, E>, mut commands: Commands) {
    let give_back = |mut camera: EntityWorldMut| {
        CameraOverrides::change(&mut camera, CameraOverrides::give_back);
    };
    commands.entity(removed.entity).queue_silenced(give_back);
}
