//! Changes that effects make to a camera and revert when they are removed: `Msaa` is switched off, `Hdr` is added.
//!
//! `#[require(Hdr)]` would not do: it does not record if the camera had `Hdr` before.
//!
//! Only the camera with the effect is changed. Cameras that draw over it may then need the same settings, which is left to the app.
//!
//! - `needs.rs`: the changes that effects need.
//! - `record.rs`: the changes made to a camera.
//! - `device.rs`: cameras are changed only for effects that the device can run.
//! - `late.rs`: warns if a camera is changed that is already rendered.
//! - `overlap.rs`: warns of cameras of one target that no longer draw into one picture.

mod device;
mod late;
mod needs;
mod overlap;
mod record;

pub(crate) use device::fit_device;

pub(crate) use needs::{CameraEffect, CameraNeeds, Need};
pub(crate) use overlap::{are_cameras_changed, warn_of_overlaps};
pub(crate) use record::keep_ticks_young;

use bevy::prelude::*;

use needs::{EffectNeeds, is_needed};
use record::CameraOverrides;

/// Label of a camera in messages: its `Name`, if it has one, and its entity.
fn label_of(camera: EntityRef) -> String {
    let id = camera.id();
    match camera.get::<Name>() {
        Some(name) => format!("{name} ({id})"),
        None => id.to_string(),
    }
}

/// Changes cameras once when they get the effect `E`, and reverts that when they lose it. `can_run` tells if the device
/// of the main world can run it; otherwise cameras stay unchanged.
pub(crate) fn add_to<E: CameraEffect>(app: &mut App, can_run: fn(&World) -> bool) {
    let effect = app.world_mut().register_component::<E>();
    let mut needs = app.world_mut().resource_mut::<CameraNeeds>();
    needs.0.push(EffectNeeds {
        name: E::NAME,
        effect,
        needs: E::NEEDS,
        can_run,
        runs: false,
    });
    app.add_observer(override_camera::<E>)
        .add_observer(give_back::<E>);
}

/// Handles entities that get an effect before they become a camera.
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
