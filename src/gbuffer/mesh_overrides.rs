//! Tracks meshes whose other components add to the needs of their material.

use core::mem::replace;

use bevy::{
    camera::visibility::RenderLayers,
    ecs::entity_disabling::Disabled,
    light::NotShadowReceiver,
    prelude::*,
    render::{
        Extract,
        sync_world::{MainEntity, MainEntityHashMap, MainEntityHashSet},
    },
};

use crate::{
    shader_library::layout::{DEFAULT_VISIBILITY_MASK, visibility_mask},
    view::{GBufferTargets, LeanDeferred},
};

/// In the render world: meshes whose components changed their needs of the G-buffer since the last frame. Lean views
/// sort them again; Bevy does not requeue them.
#[derive(Resource, Default)]
pub(crate) struct ChangedMeshes(MainEntityHashSet);

impl ChangedMeshes {
    pub(super) fn insert(&mut self, mesh: MainEntity) {
        self.0.insert(mesh);
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = MainEntity> {
        self.0.iter().copied()
    }
}

pub(super) fn clear_changed_meshes(mut changed: ResMut<ChangedMeshes>) {
    changed.0.clear();
}

/// In the render world: all meshes with such components.
#[derive(Resource, Default)]
pub(crate) struct MeshOverrides {
    without_shadows: MainEntityHashSet,
    /// Masks of meshes that are not on layer 0 alone.
    visibility_masks: MainEntityHashMap<u32>,
}

impl MeshOverrides {
    /// Targets that `mesh` needs regardless of its material, lightmap and light layers.
    pub(crate) fn targets(&self, mesh: MainEntity) -> GBufferTargets {
        if self.without_shadows.contains(&mesh) {
            GBufferTargets::SPECIALIZATION
        } else {
            GBufferTargets::empty()
        }
    }

    /// Forgets the state that [`extract_mesh_overrides`] tracks.
    fn clear_followed(&mut self) {
        self.without_shadows.clear();
        self.visibility_masks.clear();
    }

    /// Returns true if that changes something.
    fn set_without_shadows(&mut self, mesh: MainEntity, is_without: bool) -> bool {
        if is_without {
            self.without_shadows.insert(mesh)
        } else {
            self.without_shadows.remove(&mesh)
        }
    }

    /// Puts `mesh` on the layers of a mask. Returns true if that changes something.
    fn put_on(&mut self, mesh: MainEntity, mask: u32) -> bool {
        let before = self.visibility_mask(mesh);
        if mask == DEFAULT_VISIBILITY_MASK {
            self.visibility_masks.remove(&mesh);
        } else {
            self.visibility_masks.insert(mesh, mask);
        }
        before != mask
    }

    /// The layers of `mesh`.
    pub(crate) fn visibility_mask(&self, mesh: MainEntity) -> u32 {
        let mask = self.visibility_masks.get(&mesh);
        mask.copied().unwrap_or(DEFAULT_VISIBILITY_MASK)
    }
}

type SpecialComponents = Or<(With<NotShadowReceiver>, With<RenderLayers>)>;

/// Tracks the components during extraction, and so changes from any schedule of the app; idle without lean cameras.
pub(super) fn extract_mesh_overrides(
    mut special: ResMut<MeshOverrides>,
    mut changed: ResMut<ChangedMeshes>,
    lean_cameras: Extract<Query<(), With<LeanDeferred>>>,
    receivers: Extract<Query<Entity, Added<NotShadowReceiver>>>,
    mut removed_receivers: Extract<RemovedComponents<NotShadowReceiver>>,
    layers: Extract<Query<(Entity, &RenderLayers), Changed<RenderLayers>>>,
    mut removed_layers: Extract<RemovedComponents<RenderLayers>>,
    // Queries skip disabled entities, so changes made meanwhile are read once they are enabled.
    mut enabled: Extract<RemovedComponents<Disabled>>,
    all: Extract<Query<(Has<NotShadowReceiver>, Option<&RenderLayers>)>>,
    candidates: Extract<
        Query<(Entity, Has<NotShadowReceiver>, Option<&RenderLayers>), SpecialComponents>,
    >,
    mut is_following: Local<bool>,
) {
    let was_following = replace(&mut *is_following, !lean_cameras.is_empty());
    if !*is_following {
        if was_following {
            special.clear_followed();
        }
        return;
    }
    if !was_following {
        // No need to record changes: a camera that becomes lean sorts all that it sees.
        for (entity, is_without_shadows, layers) in &candidates {
            let mesh = MainEntity::from(entity);
            special.set_without_shadows(mesh, is_without_shadows);
            special.put_on(
                mesh,
                layers.map_or(DEFAULT_VISIBILITY_MASK, visibility_mask),
            );
        }
        removed_receivers.clear();
        removed_layers.clear();
        enabled.clear();
        return;
    }

    let without = removed_receivers.read().map(|entity| (entity, false));
    // Insertions last: a component that was removed and inserted in one frame is present.
    for (entity, is_without) in without.chain(receivers.iter().map(|entity| (entity, true))) {
        let mesh = MainEntity::from(entity);
        if special.set_without_shadows(mesh, is_without) {
            changed.insert(mesh);
        }
    }

    for entity in removed_layers.read() {
        let mesh = MainEntity::from(entity);
        if special.put_on(mesh, DEFAULT_VISIBILITY_MASK) {
            changed.insert(mesh);
        }
    }
    for (entity, layers) in &layers {
        let mesh = MainEntity::from(entity);
        if special.put_on(mesh, visibility_mask(layers)) {
            changed.insert(mesh);
        }
    }

    for entity in enabled.read() {
        let Ok((is_without_shadows, layers)) = all.get(entity) else {
            continue;
        };
        let mesh = MainEntity::from(entity);
        let mask = layers.map_or(DEFAULT_VISIBILITY_MASK, visibility_mask);
        let receives_otherwise = special.set_without_shadows(mesh, is_without_shadows);
        if special.put_on(mesh, mask) || receives_otherwise {
            changed.insert(mesh);
        }
    }
}
