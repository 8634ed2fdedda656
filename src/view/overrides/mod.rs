//! What the effects of this crate change about a camera, and give back: `Msaa`, which is switched off, and `Hdr`, which
//! is added.
//!
//! `#[require(Hdr)]` would not do: afterwards nothing tells whether the camera had it before.
//!
//! Cameras that were alike share their main texture and depth, and each is drawn over those before it. So that they still
//! do, the same is changed about the others (`partners.rs`).

mod needs;
mod partners;
mod record;

pub(crate) use needs::{CameraEffect, CameraNeeds, Need};
pub(crate) use partners::{are_cameras_changed, fit_partners};
pub(crate) use record::keep_ticks_young;

use bevy::prelude::*;

use needs::is_needed;
use record::CameraOverrides;

/// Makes cameras fit the effect `E` when they get it, once, and gives back what they had when they lose it.
pub(crate) fn add_to<E: CameraEffect>(app: &mut App) {
    let effect = app.world_mut().register_component::<E>();
    let mut needs = app.world_mut().resource_mut::<CameraNeeds>();
    needs.add(effect, E::NEEDS);
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
        CameraOverrides::change(&mut camera, |overrides, camera| {
            for need in E::NEEDS {
                overrides.fit(camera, *need);
            }
        });
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
