//! The meshes that lean views leave to Bevy's passes, for the stage that lights them there.

use bevy::{
    platform::collections::HashMap,
    prelude::*,
    render::{sync_world::MainEntity, view::RetainedViewEntity},
};

/// In the render world: changes to the meshes that lean views leave to Bevy's passes, made in this frame.
#[derive(Resource, Default)]
pub(crate) struct LeftMeshes(HashMap<RetainedViewEntity, ViewLeftMeshes>);

/// Changes of one view. Meshes that are sorted again are removed first.
#[derive(Default)]
pub(crate) struct ViewLeftMeshes {
    /// Meshes that became invisible, changed or were sorted.
    pub(crate) removed: Vec<MainEntity>,
    /// Meshes that were left to Bevy, except for the time until their pipeline or target is ready.
    pub(crate) left: Vec<MainEntity>,
}

impl LeftMeshes {
    /// The changes of a view.
    pub(crate) fn get(&self, view: &RetainedViewEntity) -> Option<&ViewLeftMeshes> {
        self.0.get(view)
    }

    pub(super) fn start_frame(&mut self) {
        for changes in self.0.values_mut() {
            changes.removed.clear();
            changes.left.clear();
        }
    }

    pub(super) fn of(&mut self, view: RetainedViewEntity) -> &mut ViewLeftMeshes {
        self.0.entry(view).or_default()
    }

    pub(super) fn keep_only(&mut self, is_live: impl Fn(&RetainedViewEntity) -> bool) {
        self.0.retain(|view, _| is_live(view));
    }
}
