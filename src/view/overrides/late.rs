//! Warns of changes to cameras that are already rendered.

use bevy::prelude::*;

use super::{
    label_of,
    needs::{CameraEffect, Need},
};

/// On a camera: the warning was logged.
#[derive(Component)]
struct ToldOfChange;

/// Warns once per camera that the effect `E` has changed one that is already rendered: pipelines that other crates keep
/// for it may no longer match.
pub(super) fn warn_of_change<E: CameraEffect>(camera: &mut EntityWorldMut, changed: &[Need]) {
    let is_rendered = camera
        .get::<Camera>()
        .is_some_and(|camera| camera.is_active && camera.physical_target_size().is_some());
    if changed.is_empty() || !is_rendered || camera.contains::<ToldOfChange>() {
        return;
    }
    camera.insert(ToldOfChange);
    let names = Need::list(changed);
    let effect = E::NAME;
    let label = label_of(camera.as_readonly());
    warn!(
        "Camera {label} was rendered without {names} before {effect} was inserted, which needs it. Bevy recreates its own \
         pipelines; pipelines that other crates cache per camera (outlines, particles) may no longer match, which ends the \
         app. If so, spawn it with {names}."
    );
}
