//! Rules by which Bevy queues meshes: for which cameras, for which meshes it waits, and in which order.

use bevy::{
    asset::UntypedAssetId,
    material::{MaterialProperties, OpaqueRendererMethod, RenderPhaseType},
    pbr::{
        MorphIndices, PreparedMaterial, RenderMaterialInstances, RenderMeshInstanceFlags,
        RenderMeshInstances, RenderMeshQueueData,
    },
    prelude::*,
    render::{
        erased_render_asset::ErasedRenderAssets,
        mesh::{
            RenderMesh,
            allocator::{MeshAllocator, MeshSlabs},
        },
        render_asset::RenderAssets,
        sync_world::MainEntity,
        view::RenderVisibleEntitiesClass,
    },
};

use crate::gpu::named::system_param;

/// True if Bevy extracts the camera in this frame. False while its window is minimised: its target then has size 0.
pub(in crate::gbuffer) fn is_extracted(camera: &Camera) -> bool {
    let has_pixels = |size: UVec2| size.cmpne(UVec2::ZERO).all();
    camera.is_active && camera.physical_target_size().is_none_or(has_pixels)
}

/// Returns the entities of a visible mesh, searched as in Bevy's `DirtySpecializations`.
pub(in crate::gbuffer) fn visible_pair(
    visible: &RenderVisibleEntitiesClass,
    mesh: MainEntity,
) -> Option<(Entity, MainEntity)> {
    let culled_on_cpu = &visible.entities_cpu_culling;
    match culled_on_cpu.binary_search_by_key(&mesh, |(_, main_entity)| *main_entity) {
        Ok(index) => Some(culled_on_cpu[index]),
        Err(_) => {
            let entity = visible.entities_gpu_culling.get(&mesh)?;
            Some((*entity, mesh))
        }
    }
}

/// Keeps the visible ones of the meshes that Bevy waited for, in the order in which it queues them: by entity. It decides
/// the draw order, and so which mesh wins at equal depth.
pub(in crate::gbuffer) fn keep_visible_in_order(
    waiting: &mut Vec<(Entity, MainEntity)>,
    visible: &RenderVisibleEntitiesClass,
) {
    // Bevy's own look-up by both entities misses some meshes that are also, say, lights: only those have entities in the
    // render world, while its list is sorted by main-world entity.
    waiting.retain(|pair| visible_pair(visible, pair.1) == Some(*pair));
    waiting.sort_unstable_by_key(|(_, entity)| *entity);
}

/// True if Bevy queues a mesh of this material for its deferred pass and no other.
pub(in crate::gbuffer) fn is_for_deferred_pass(properties: &MaterialProperties) -> bool {
    properties.render_method == OpaqueRendererMethod::Deferred
        && matches!(
            properties.render_phase_type,
            RenderPhaseType::Opaque | RenderPhaseType::AlphaMask
        )
}

system_param! {
    /// Resources in which Bevy looks up a mesh before it queues it. For a mesh that is not ready, the results are `Err(true)` if
    /// Bevy waits for it, and `Err(false)` if it does not.
    pub(in crate::gbuffer) struct BevyLookup<'w> {
        mesh_instances: Res<'w, RenderMeshInstances>,
        material_instances: Res<'w, RenderMaterialInstances>,
        materials: Res<'w, ErasedRenderAssets<PreparedMaterial>>,
        meshes: Res<'w, RenderAssets<RenderMesh>>,
        mesh_allocator: Res<'w, MeshAllocator>,
        morph_indices: Res<'w, MorphIndices>,
    }
}

impl BevyLookup<'_> {
    /// The material and the instance of a mesh.
    pub(in crate::gbuffer) fn instance(
        &self,
        mesh: MainEntity,
    ) -> Result<(UntypedAssetId, RenderMeshQueueData<'_>), bool> {
        let material = self.material_instances.instances.get(&mesh).ok_or(true)?;
        let instance = (self.mesh_instances)
            .render_mesh_queue_data(mesh)
            .ok_or(true)?;
        Ok((material.asset_id, instance))
    }

    /// The assets of an instance.
    pub(in crate::gbuffer) fn assets(
        &self,
        material: UntypedAssetId,
        mesh: AssetId<Mesh>,
    ) -> Result<(&PreparedMaterial, &RenderMesh, MeshSlabs), bool> {
        Ok((
            self.materials.get(material).ok_or(true)?,
            self.meshes.get(mesh).ok_or(false)?,
            self.mesh_allocator.mesh_slabs(&mesh).ok_or(false)?,
        ))
    }

    /// True if Bevy has only this frame's morph weights. The previous ones exist from the next frame on, and need
    /// another pipeline.
    pub(in crate::gbuffer) fn awaits_previous_morph(
        &self,
        mesh: MainEntity,
        instance: &RenderMeshQueueData,
    ) -> bool {
        let is_morphed = match &*self.morph_indices {
            MorphIndices::Uniform { current, .. } => current.contains_key(&mesh),
            MorphIndices::Storage {
                morph_weights_info, ..
            } => morph_weights_info.contains_key(&mesh),
        };
        let flags = instance.flags();
        is_morphed && !flags.contains(RenderMeshInstanceFlags::HAS_PREVIOUS_MORPH)
    }
}
