//! What a mesh needs of the G-buffer, and whether that can carry it.

use bevy::{
    asset::UntypedAssetId,
    ecs::system::SystemParam,
    material::RenderPhaseType,
    pbr::{
        MeshPipeline, MeshPipelineKey, MorphIndices, PreparedMaterial, RenderMaterialInstances,
        RenderMeshInstanceFlags, RenderMeshInstances, RenderMeshQueueData,
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
        view::RenderVisibilityRanges,
    },
};

use super::{
    demand::Demand,
    layout::DEFAULT_VISIBILITY_MASK,
    material::GBufferMaterials,
    moving::MovingMeshes,
    special::SpecialMeshes,
    targets::{GBufferTargets, ShadingModel},
};
use crate::lighting::LightingVariant;

/// What is known of meshes and materials, to find out how one is drawn.
#[derive(SystemParam)]
pub(super) struct MeshLookup<'w> {
    mesh_instances: Res<'w, RenderMeshInstances>,
    material_instances: Res<'w, RenderMaterialInstances>,
    materials: Res<'w, ErasedRenderAssets<PreparedMaterial>>,
    meshes: Res<'w, RenderAssets<RenderMesh>>,
    mesh_allocator: Res<'w, MeshAllocator>,
    gbuffer_materials: Res<'w, GBufferMaterials>,
    pub(super) special_meshes: Res<'w, SpecialMeshes>,
    moving_meshes: Res<'w, MovingMeshes>,
    morph_indices: Res<'w, MorphIndices>,
    pub(super) visibility_ranges: Res<'w, RenderVisibilityRanges>,
    mesh_pipeline: Res<'w, MeshPipeline>,
}

/// A mesh of which everything is loaded.
pub(super) struct MeshToQueue<'a> {
    pub(super) instance: RenderMeshQueueData<'a>,
    pub(super) material: &'a PreparedMaterial,
    pub(super) material_id: UntypedAssetId,
    pub(super) mesh: &'a RenderMesh,
    pub(super) slabs: MeshSlabs,
}

impl MeshToQueue<'_> {
    /// Whether its vertices may move within it.
    fn deforms(&self) -> bool {
        self.mesh.layout.0.contains(Mesh::ATTRIBUTE_JOINT_INDEX)
            || MeshPipelineKey::from_bits_retain(self.mesh.key_bits.bits())
                .contains(MeshPipelineKey::MORPH_TARGETS)
    }
}

impl MeshLookup<'_> {
    /// `Err(true)` if it may be there in a later frame, `Err(false)` if waiting is of no use. The conditions are those
    /// of Bevy's own queue systems, so that both wait for the same meshes.
    pub(super) fn find(&self, entity: MainEntity) -> Result<MeshToQueue<'_>, bool> {
        let material_instance = self.material_instances.instances.get(&entity).ok_or(true)?;
        let instance = self
            .mesh_instances
            .render_mesh_queue_data(entity)
            .ok_or(true)?;
        let material = self.materials.get(material_instance.asset_id).ok_or(true)?;
        let mesh = self.meshes.get(instance.mesh_asset_id()).ok_or(false)?;
        let slabs = self
            .mesh_allocator
            .mesh_slabs(&instance.mesh_asset_id())
            .ok_or(false)?;
        Ok(MeshToQueue {
            instance,
            material,
            material_id: material_instance.asset_id,
            mesh,
            slabs,
        })
    }

    /// Whether Bevy has only this frame's weights of the morph targets: those of the last are there from the next frame
    /// on, for which other pipelines are needed.
    pub(super) fn awaits_previous_morph(&self, entity: MainEntity, mesh: &MeshToQueue) -> bool {
        let flags = mesh.instance.flags();
        let is_morphed = match &*self.morph_indices {
            MorphIndices::Uniform { current, .. } => current.contains_key(&entity),
            MorphIndices::Storage {
                morph_weights_info, ..
            } => morph_weights_info.contains_key(&entity),
        };
        is_morphed && !flags.contains(RenderMeshInstanceFlags::HAS_PREVIOUS_MORPH)
    }

    /// What it may need, and the fragment shader to draw it into the G-buffer with, or `None` if forward must draw it.
    pub(super) fn gbuffer_needs(
        &self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        view_key: MeshPipelineKey,
    ) -> Option<(Demand, &Handle<Shader>)> {
        let opaque = matches!(
            mesh.material.properties.render_phase_type,
            RenderPhaseType::Opaque | RenderPhaseType::AlphaMask
        );
        // Without normals forward lights by what the vertex shader happens to leave there; it alone can match that.
        let has_normals = mesh.mesh.layout.0.contains(Mesh::ATTRIBUTE_NORMAL);
        if !opaque || !has_normals {
            return None;
        }
        let (needs, shader) = self.gbuffer_materials.get(mesh.material_id)?;
        // The same without tangents.
        if needs.shading_model == ShadingModel::Anisotropy
            && !mesh.mesh.layout.0.contains(Mesh::ATTRIBUTE_TANGENT)
        {
            return None;
        }
        let lightmapped = self.special_meshes.lightmap_key(entity).is_some();
        // Bevy's `environment_map.wgsl` does not compile for lightmaps without binding arrays. Forward draws nothing
        // there either; but lighting that is never compiled would keep all other special surfaces waiting.
        if lightmapped
            && view_key.contains(MeshPipelineKey::ENVIRONMENT_MAP)
            && !self.mesh_pipeline.binding_arrays_are_usable
        {
            return None;
        }
        let mut targets = needs.targets | self.special_meshes.targets(entity);
        if mesh.deforms() || self.moving_meshes.contains(entity) {
            targets |= GBufferTargets::MOTION;
        }
        if self.special_meshes.visibility_mask(entity) != DEFAULT_VISIBILITY_MASK {
            targets |= GBufferTargets::VISIBILITY_MASK;
        }
        let demand = Demand {
            targets,
            variants: LightingVariant::new(needs.shading_model, lightmapped).as_set(),
        };
        Some((demand, shader))
    }
}
