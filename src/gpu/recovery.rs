//! What is left of a device that was lost.
//!
//! Bevy makes the resources of the render world anew on the next device, but keeps its entities, with the buffers and
//! bind groups of the last one in their components.

use bevy::{
    prelude::*,
    render::{extract_component::ExtractComponent, sync_component::SyncComponent},
};

/// Takes from all views what they have because of `C`, as if it was removed; in `RenderStartup`. Extraction then brings
/// `C` back.
pub(crate) fn forget<C: ExtractComponent>(mut commands: Commands, views: Query<Entity, With<C>>) {
    for entity in &views {
        commands
            .entity(entity)
            .remove::<<C as SyncComponent>::Target>();
    }
}
