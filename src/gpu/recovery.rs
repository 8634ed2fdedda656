//! Cleans up after a lost device.
//!
//! Bevy recreates the resources of the render world on the next device, but keeps its entities, with the buffers and
//! bind groups of the lost one in their components.

use bevy::{
    prelude::*,
    render::{extract_component::ExtractComponent, sync_component::SyncComponent},
};

/// Removes `C` and its dependent components from all views; runs in `RenderStartup`. Extraction then inserts `C` again.
pub(crate) fn forget<C: ExtractComponent>(mut commands: Commands, views: Query<Entity, With<C>>) {
    for entity in &views {
        commands
            .entity(entity)
            .remove::<<C as SyncComponent>::Target>();
    }
}
