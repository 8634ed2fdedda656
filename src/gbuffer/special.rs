//! Meshes of which the G-buffer must know more than their material says: what their other components are.

use core::mem::replace;

use bevy::{
    camera::visibility::{RenderLayers, ViewVisibility},
    ecs::entity_disabling::Disabled,
    light::NotShadowReceiver,
    pbr::{Lightmap, MeshPipelineKey},
    prelude::*,
    render::{
        Extract,
        camera::DirtySpecializations,
        sync_world::{MainEntity, MainEntityHashMap, MainEntityHashSet},
    },
};

use super::layout::{DEFAULT_VISIBILITY_MASK, visibility_mask};
use crate::view::{GBufferTargets, LeanDeferred};

/// In the render world: meshes whose components changed what they need of the G-buffer, since the last frame. Lean views
/// sort them anew; Bevy does not look at them again.
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

/// In the render world: all such meshes.
#[derive(Resource, Default)]
pub(crate) struct SpecialMeshes {
    without_shadows: MainEntityHashSet,
    /// With whether the lightmap is sampled bicubically.
    lightmapped: MainEntityHashMap<bool>,
    /// Those on other layers than layer 0 alone.
    visibility_masks: MainEntityHashMap<u32>,
}

impl SpecialMeshes {
    /// The targets that `mesh` needs, whatever its material, on views that tell light by layers and on others.
    pub(crate) fn targets(&self, mesh: MainEntity) -> GBufferTargets {
        let mut targets = GBufferTargets::empty();
        if self.without_shadows.contains(&mesh) {
            targets |= GBufferTargets::SPECIALIZATION;
        }
        if self.lightmapped.contains_key(&mesh) {
            targets |= GBufferTargets::EMISSIVE | GBufferTargets::SPECIALIZATION;
        }
        targets
    }

    /// What the lightmap of `mesh`, if it has one, adds to the key of its pipelines.
    pub(crate) fn lightmap_key(&self, mesh: MainEntity) -> Option<MeshPipelineKey> {
        let bicubic = *self.lightmapped.get(&mesh)?;
        let mut key = MeshPipelineKey::LIGHTMAPPED;
        key.set(MeshPipelineKey::LIGHTMAP_BICUBIC_SAMPLING, bicubic);
        Some(key)
    }

    /// Forgets what [`extract_special_meshes`] follows.
    fn clear_followed(&mut self) {
        self.without_shadows.clear();
        self.visibility_masks.clear();
    }

    /// Whether that changes something.
    fn set_without_shadows(&mut self, mesh: MainEntity, is_without: bool) -> bool {
        if is_without {
            self.without_shadows.insert(mesh)
        } else {
            self.without_shadows.remove(&mesh)
        }
    }

    /// Puts `mesh` on the layers of a mask. Whether that changes something.
    fn put_on(&mut self, mesh: MainEntity, mask: u32) -> bool {
        let before = self.visibility_mask(mesh);
        if mask == DEFAULT_VISIBILITY_MASK {
            self.visibility_masks.remove(&mesh);
        } else {
            self.visibility_masks.insert(mesh, mask);
        }
        before != mask
    }

    /// The layers that `mesh` is on.
    pub(crate) fn visibility_mask(&self, mesh: MainEntity) -> u32 {
        let mask = self.visibility_masks.get(&mesh);
        mask.copied().unwrap_or(DEFAULT_VISIBILITY_MASK)
    }
}

type SpecialComponents = Or<(With<NotShadowReceiver>, With<RenderLayers>)>;

/// Follows the components in extraction, whenever the app changed them; while no camera is to be lean, it does not.
pub(super) fn extract_special_meshes(
    mut special: ResMut<SpecialMeshes>,
    mut changed: ResMut<ChangedMeshes>,
    lean_cameras: Extract<Query<(), With<LeanDeferred>>>,
    receivers: Extract<Query<Entity, Added<NotShadowReceiver>>>,
    mut removed_receivers: Extract<RemovedComponents<NotShadowReceiver>>,
    layers: Extract<Query<(Entity, &RenderLayers), Changed<RenderLayers>>>,
    mut removed_layers: Extract<RemovedComponents<RenderLayers>>,
    // What changed while they were disabled no query has told.
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
        // All that a camera sees is sorted when it becomes lean.
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
    // What was removed and inserted in one frame is there.
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

/// On a new device Bevy's list, which is made anew there, is empty.
pub(super) fn forget_lightmapped_meshes(mut special: ResMut<SpecialMeshes>) {
    special.lightmapped.clear();
}

/// Keeps the same lightmapped meshes as Bevy's private `extract_lightmaps`, by its rules, because by that list Bevy picks
/// the bind group of a mesh: a pipeline made for another one is an error. Bevy does not look at pipelines again when that
/// changes, so it is asked to; without lean cameras too, because the error ends the app there as well.
pub(super) fn extract_lightmapped_meshes(
    mut special: ResMut<SpecialMeshes>,
    mut dirty: ResMut<DirtySpecializations>,
    changed: Extract<
        Query<
            (Entity, &ViewVisibility, &Lightmap),
            Or<(Changed<ViewVisibility>, Changed<Lightmap>)>,
        >,
    >,
    mut removed: Extract<RemovedComponents<Lightmap>>,
) {
    for (entity, visibility, lightmap) in &changed {
        let mesh = MainEntity::from(entity);
        if visibility.get() && !special.lightmapped.contains_key(&mesh) {
            special.lightmapped.insert(mesh, lightmap.bicubic_sampling);
            dirty.changed_renderables.insert(mesh);
        }
    }
    for entity in removed.read() {
        let mesh = MainEntity::from(entity);
        if !changed.contains(entity) && special.lightmapped.remove(&mesh).is_some() {
            dirty.changed_renderables.insert(mesh);
        }
    }
}
