//! Mirrors Bevy's list of lightmapped meshes.

use bevy::{
    camera::visibility::ViewVisibility,
    pbr::{Lightmap, MeshPipelineKey},
    prelude::*,
    render::{
        Extract,
        camera::DirtySpecializations,
        sync_world::{MainEntity, MainEntityHashMap},
    },
};

/// In the render world: the meshes that Bevy draws with a lightmap. True if the lightmap is sampled bicubically.
#[derive(Resource, Default)]
pub(in crate::gbuffer) struct LightmappedMeshes(MainEntityHashMap<bool>);

impl LightmappedMeshes {
    /// Key bits that the lightmap of `mesh`, if any, adds to its pipelines.
    pub(in crate::gbuffer) fn key(&self, mesh: MainEntity) -> Option<MeshPipelineKey> {
        let bicubic = *self.0.get(&mesh)?;
        let mut key = MeshPipelineKey::LIGHTMAPPED;
        key.set(MeshPipelineKey::LIGHTMAP_BICUBIC_SAMPLING, bicubic);
        Some(key)
    }
}

/// Matches Bevy's list, which is recreated empty on a new device.
pub(in crate::gbuffer) fn forget_lightmapped_meshes(mut lightmapped: ResMut<LightmappedMeshes>) {
    lightmapped.0.clear();
}

/// Mirrors the list of lightmapped meshes in Bevy's private `extract_lightmaps`, by its rules: Bevy selects a mesh's
/// bind group by that list, and a pipeline specialized for another one is an error. Bevy does not respecialize when the
/// list changes, so the mesh is marked as changed; without lean cameras too, because the error ends the app there as
/// well.
pub(in crate::gbuffer) fn extract_lightmapped_meshes(
    mut lightmapped: ResMut<LightmappedMeshes>,
    mut dirty: ResMut<DirtySpecializations>,
    changed: Extract<
        Query<
            (Entity, &ViewVisibility, &Lightmap),
            Or<(Changed<ViewVisibility>, Changed<Lightmap>)>,
        >,
    >,
    mut removed: Extract<RemovedComponents<Lightmap>>,
) {
    let lightmapped = &mut lightmapped.0;
    for (entity, visibility, lightmap) in &changed {
        let mesh = MainEntity::from(entity);
        if visibility.get() && !lightmapped.contains_key(&mesh) {
            lightmapped.insert(mesh, lightmap.bicubic_sampling);
            dirty.changed_renderables.insert(mesh);
        }
    }
    for entity in removed.read() {
        let mesh = MainEntity::from(entity);
        if !changed.contains(entity) && lightmapped.remove(&mesh).is_some() {
            dirty.changed_renderables.insert(mesh);
        }
    }
}
