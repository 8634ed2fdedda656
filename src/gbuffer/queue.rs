//! Sorts the meshes of a lean view: into the G-buffer, out of Bevy's forward phases, or left to those.

use bevy::{
    asset::UntypedAssetId,
    core_pipeline::{
        core_3d::{AlphaMask3d, Opaque3d, Opaque3dBatchSetKey, Opaque3dBinKey},
        prepass::{AlphaMask3dPrepass, Opaque3dPrepass},
    },
    ecs::system::SystemParam,
    material::{
        OpaqueRendererMethod, RenderPhaseType,
        key::{ErasedMaterialPipelineKey, ErasedMeshPipelineKey},
    },
    mesh::Mesh3d,
    pbr::{
        DrawPrepass, MainPassOpaqueDrawFunction, MeshPipeline, MeshPipelineKey, MorphIndices,
        PreparedMaterial, PrepassPipeline, RenderMaterialInstances, RenderMeshInstanceFlags,
        RenderMeshInstances, RenderMeshQueueData, SpecializedMaterialPipelineCache, ViewKeyCache,
        alpha_mode_pipeline_key,
    },
    platform::collections::HashSet,
    prelude::*,
    render::{
        batching::gpu_preprocessing::GpuPreprocessingSupport,
        camera::{DirtySpecializations, PendingQueues},
        erased_render_asset::ErasedRenderAssets,
        mesh::{
            RenderMesh,
            allocator::{MeshAllocator, MeshSlabs},
        },
        render_asset::RenderAssets,
        render_phase::{
            BinnedRenderPhaseType, DrawFunctionId, DrawFunctions, ViewBinnedRenderPhases,
        },
        render_resource::{CachedRenderPipelineId, PipelineCache, SpecializedMeshPipelines},
        sync_world::MainEntity,
        view::{ExtractedView, RenderVisibilityRanges, RenderVisibleEntities, RetainedViewEntity},
    },
};

use super::{
    demand::{Demand, ViewDemands},
    layout::{DEFAULT_VISIBILITY_MASK, visibility_mask},
    material::{GBufferMaterials, SpecialMeshes},
    moving::MovingMeshes,
    phase::{
        AlphaMaskGBuffer, ExtendedAlphaMaskGBuffer, ExtendedOpaqueGBuffer, GBufferPhases,
        OpaqueGBuffer, QueuedMesh,
    },
    pipeline::{GBufferPipelineSpecializer, MeshOutput, VIEW_KEY_BITS},
    targets::{GBufferTargets, ShadingModel},
};
use crate::{LeanDeferred, camera::ActiveLeanView, lighting::LightingVariant};

/// Meshes whose assets or pipelines were not ready; tried again each frame, drawn by forward until then.
#[derive(Resource, Default)]
pub(super) struct PendingGBufferQueues(PendingQueues);

/// What is known of meshes and materials, to find out how one is drawn.
#[derive(SystemParam)]
pub(super) struct MeshLookup<'w> {
    mesh_instances: Res<'w, RenderMeshInstances>,
    material_instances: Res<'w, RenderMaterialInstances>,
    materials: Res<'w, ErasedRenderAssets<PreparedMaterial>>,
    meshes: Res<'w, RenderAssets<RenderMesh>>,
    mesh_allocator: Res<'w, MeshAllocator>,
    gbuffer_materials: Res<'w, GBufferMaterials>,
    special_meshes: Res<'w, SpecialMeshes>,
    moving_meshes: Res<'w, MovingMeshes>,
    morph_indices: Res<'w, MorphIndices>,
    visibility_ranges: Res<'w, RenderVisibilityRanges>,
    mesh_pipeline: Res<'w, MeshPipeline>,
}

/// A mesh of which everything is loaded.
struct MeshToQueue<'a> {
    instance: RenderMeshQueueData<'a>,
    material: &'a PreparedMaterial,
    material_id: UntypedAssetId,
    mesh: &'a RenderMesh,
    slabs: MeshSlabs,
}

impl MeshToQueue<'_> {
    /// Whether its vertices may move within it.
    fn deforms(&self) -> bool {
        self.mesh.layout.0.contains(Mesh::ATTRIBUTE_JOINT_INDEX)
            || MeshPipelineKey::from_bits_retain(self.mesh.key_bits.bits())
                .contains(MeshPipelineKey::MORPH_TARGETS)
    }

    fn visibility_mask(&self) -> u32 {
        let layers = self.instance.render_layers.as_ref();
        layers.map_or(DEFAULT_VISIBILITY_MASK, visibility_mask)
    }
}

impl MeshLookup<'_> {
    /// `Err(true)` if it may be there in a later frame, `Err(false)` if waiting is of no use. The conditions are those
    /// of Bevy's own queue systems, so that both wait for the same meshes.
    fn find(&self, entity: MainEntity) -> Result<MeshToQueue<'_>, bool> {
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
    fn awaits_previous_morph(&self, entity: MainEntity, mesh: &MeshToQueue) -> bool {
        let flags = mesh.instance.flags();
        let is_morphed = match &*self.morph_indices {
            MorphIndices::Uniform { current, .. } => current.contains_key(&entity),
            MorphIndices::Storage {
                morph_weights_info, ..
            } => morph_weights_info.contains_key(&entity),
        };
        is_morphed && !flags.contains(RenderMeshInstanceFlags::HAS_PREVIOUS_MORPH)
    }

    /// What it needs, and the fragment shader to draw it into the G-buffer with, or `None` if forward must draw it.
    fn gbuffer_needs(
        &self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        view: &ActiveLeanView,
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
        targets.set(
            GBufferTargets::MOTION,
            view.resolves_motion && targets.contains(GBufferTargets::MOTION),
        );
        if view.has_light_layers && mesh.visibility_mask() != DEFAULT_VISIBILITY_MASK {
            targets |= GBufferTargets::VISIBILITY_MASK;
        }
        let demand = Demand {
            targets,
            variants: LightingVariant::new(needs.shading_model, lightmapped).as_set(),
        };
        Some((demand, shader))
    }
}

/// The pipelines of the G-buffer and what makes them.
#[derive(SystemParam)]
pub(super) struct GBufferPipelines<'w> {
    cache: Res<'w, PipelineCache>,
    prepass_pipeline: Res<'w, PrepassPipeline>,
    specialized: ResMut<'w, SpecializedMeshPipelines<GBufferPipelineSpecializer>>,
}

impl GBufferPipelines<'_> {
    fn specialize(
        &mut self,
        lookup: &MeshLookup,
        entity: MainEntity,
        mesh: &MeshToQueue,
        view_key: MeshPipelineKey,
        fragment_shader: &Handle<Shader>,
        output: MeshOutput,
    ) -> Option<CachedRenderPipelineId> {
        let properties = &mesh.material.properties;
        let mut mesh_key = (view_key & VIEW_KEY_BITS)
            | MeshPipelineKey::from_msaa_samples(1)
            | MeshPipelineKey::DEFERRED_PREPASS
            | MeshPipelineKey::from_bits_retain(mesh.mesh.key_bits.bits())
            | alpha_mode_pipeline_key(properties.alpha_mode, &Msaa::Off);
        if lookup
            .visibility_ranges
            .entity_has_crossfading_visibility_ranges(entity)
        {
            mesh_key |= MeshPipelineKey::VISIBILITY_RANGE_DITHER;
        }
        if let Some(lightmap) = lookup.special_meshes.lightmap_key(entity) {
            mesh_key |= lightmap;
        }
        if output.writes_motion {
            let flags = mesh.instance.flags();
            mesh_key.set(
                MeshPipelineKey::HAS_PREVIOUS_SKIN,
                flags.contains(RenderMeshInstanceFlags::HAS_PREVIOUS_SKIN),
            );
            mesh_key.set(
                MeshPipelineKey::HAS_PREVIOUS_MORPH,
                flags.contains(RenderMeshInstanceFlags::HAS_PREVIOUS_MORPH),
            );
        }
        let key = ErasedMaterialPipelineKey {
            type_id: mesh.material_id.type_id(),
            mesh_key: ErasedMeshPipelineKey::new(mesh_key),
            material_key: properties.material_key.clone(),
        };
        let specializer = GBufferPipelineSpecializer {
            pipeline: self.prepass_pipeline.clone(),
            properties: properties.clone(),
            fragment_shader: fragment_shader.clone(),
        };
        self.specialized
            .specialize(
                &self.cache,
                &specializer,
                (key, fragment_shader.id(), output),
                &mesh.mesh.layout,
            )
            .inspect_err(|error| error!("G-buffer pipeline: {error}"))
            .ok()
    }

    fn is_ready(&self, pipeline: CachedRenderPipelineId) -> bool {
        self.cache.get_render_pipeline(pipeline).is_some()
    }
}

/// Bevy's phases that meshes of the G-buffer are taken out of.
#[derive(SystemParam)]
pub(super) struct BevyPhases<'w> {
    opaque: ResMut<'w, ViewBinnedRenderPhases<Opaque3d>>,
    alpha_mask: ResMut<'w, ViewBinnedRenderPhases<AlphaMask3d>>,
    opaque_prepass: ResMut<'w, ViewBinnedRenderPhases<Opaque3dPrepass>>,
    alpha_mask_prepass: ResMut<'w, ViewBinnedRenderPhases<AlphaMask3dPrepass>>,
    pipelines: Res<'w, SpecializedMaterialPipelineCache>,
}

impl BevyPhases<'_> {
    fn remove(&mut self, view: &ExtractedView, entity: MainEntity, keeps_prepass: bool) {
        let view = &view.retained_view_entity;
        if let Some(phase) = self.opaque.get_mut(view) {
            phase.remove(entity);
        }
        if let Some(phase) = self.alpha_mask.get_mut(view) {
            phase.remove(entity);
        }
        if keeps_prepass {
            return;
        }
        if let Some(phase) = self.opaque_prepass.get_mut(view) {
            phase.remove(entity);
        }
        if let Some(phase) = self.alpha_mask_prepass.get_mut(view) {
            phase.remove(entity);
        }
    }

    /// Bevy leaves opaque meshes whose method is `Deferred` to its own deferred pass, which a lean view does not have.
    /// Those that the G-buffer does not carry either are put into the forward phase here.
    fn add_deferred_as_forward(
        &mut self,
        view: &ExtractedView,
        entity: MainEntity,
        mesh: &MeshToQueue,
        phase_type: BinnedRenderPhaseType,
    ) {
        let properties = &mesh.material.properties;
        if !matches!(properties.render_phase_type, RenderPhaseType::Opaque)
            || properties.render_method != OpaqueRendererMethod::Deferred
        {
            return;
        }
        let view = &view.retained_view_entity;
        let (Some(phase), Some(pipeline), Some(draw_function)) = (
            self.opaque.get_mut(view),
            self.pipelines
                .get(view)
                .and_then(|pipelines| pipelines.get(&entity)),
            properties.get_draw_function(MainPassOpaqueDrawFunction),
        ) else {
            return;
        };
        phase.remove(entity);
        phase.add(
            Opaque3dBatchSetKey {
                pipeline: *pipeline,
                draw_function,
                material_bind_group_index: Some(mesh.material.binding.group.0),
                slabs: mesh.slabs,
                lightmap_slab: mesh.instance.lightmap_slab_index().map(|index| *index),
            },
            Opaque3dBinKey {
                asset_id: mesh.instance.mesh_asset_id().into(),
            },
            (Entity::PLACEHOLDER, entity),
            mesh.instance.current_uniform_index,
            phase_type,
        );
    }
}

/// How the meshes of each phase are drawn.
#[derive(SystemParam)]
pub(super) struct GBufferDrawFunctions<'w> {
    opaque: Res<'w, DrawFunctions<OpaqueGBuffer>>,
    alpha_mask: Res<'w, DrawFunctions<AlphaMaskGBuffer>>,
    extended_opaque: Res<'w, DrawFunctions<ExtendedOpaqueGBuffer>>,
    extended_alpha_mask: Res<'w, DrawFunctions<ExtendedAlphaMaskGBuffer>>,
}

impl GBufferDrawFunctions<'_> {
    fn get(&self, extended: bool, alpha_masked: bool) -> DrawFunctionId {
        match (extended, alpha_masked) {
            (false, false) => self.opaque.read().id::<DrawPrepass>(),
            (false, true) => self.alpha_mask.read().id::<DrawPrepass>(),
            (true, false) => self.extended_opaque.read().id::<DrawPrepass>(),
            (true, true) => self.extended_alpha_mask.read().id::<DrawPrepass>(),
        }
    }
}

/// After Bevy's own queue systems: moves the meshes that the G-buffer carries into its phases. Looks only at meshes
/// that became visible, changed, or were not ready before.
///
/// A mesh that needs more than its view has is left to forward, and its need recorded: the view has it from a later
/// frame on, once lighting is compiled for it.
pub(super) fn queue_gbuffer_meshes(
    lookup: MeshLookup,
    mut pipelines: GBufferPipelines,
    mut bevy_phases: BevyPhases,
    mut phases: GBufferPhases,
    (mut pending_queues, mut demands): (ResMut<PendingGBufferQueues>, ResMut<ViewDemands>),
    draw_functions: GBufferDrawFunctions,
    (view_keys, dirty, gpu_preprocessing): (
        Res<ViewKeyCache>,
        Res<DirtySpecializations>,
        Res<GpuPreprocessingSupport>,
    ),
    views: Query<
        (
            &ExtractedView,
            &RenderVisibleEntities,
            Option<&ActiveLeanView>,
        ),
        With<LeanDeferred>,
    >,
    mut live_views: Local<HashSet<RetainedViewEntity>>,
) {
    live_views.clear();

    for (view, visible_entities, active) in &views {
        let retained = view.retained_view_entity;
        let Some(active) = active else {
            // Bevy has queued everything itself.
            phases.remove_view(&retained);
            continue;
        };
        live_views.insert(retained);
        let (true, Some(view_key), Some(visible)) = (
            phases.has_view(&retained),
            view_keys.get(&retained),
            visible_entities.get::<Mesh3d>(),
        ) else {
            continue;
        };
        let pending = pending_queues.0.prepare_for_new_frame(retained);
        let view_demand = demands.of(retained);

        for &entity in dirty.iter_to_dequeue(retained, visible) {
            phases.remove(&retained, entity);
            view_demand.remove(entity);
        }

        for (render_entity, &entity) in dirty.iter_to_queue(retained, visible, &pending.prev_frame)
        {
            let mesh = match lookup.find(entity) {
                Ok(mesh) => mesh,
                Err(may_come) => {
                    if may_come {
                        pending.current_frame.insert((*render_entity, entity));
                    }
                    continue;
                }
            };
            let phase_type =
                BinnedRenderPhaseType::mesh(mesh.instance.should_batch(), &gpu_preprocessing);
            let Some((demand, shader)) = lookup.gbuffer_needs(entity, &mesh, active, *view_key)
            else {
                bevy_phases.add_deferred_as_forward(view, entity, &mesh, phase_type);
                continue;
            };
            view_demand.insert(entity, demand);
            let extended = !demand.targets.is_empty() || active.extends_all();
            let alpha_masked = matches!(
                mesh.material.properties.render_phase_type,
                RenderPhaseType::AlphaMask
            );
            // Bevy draws what it can batch first, in the order of the keys; what comes then may lie before anything.
            let is_in_order = !alpha_masked
                && !matches!(phase_type, BinnedRenderPhaseType::UnbatchableMesh)
                && !active.extends_all();
            let (pass, targets) = match (extended, is_in_order) {
                (false, _) => default(),
                (true, true) => (active.targets, active.targets.up_to(demand.targets)),
                (true, false) => (active.targets, active.targets),
            };
            let output = MeshOutput {
                pass,
                targets,
                writes_motion: demand.targets.contains(GBufferTargets::MOTION),
                visibility_mask: if targets.contains(GBufferTargets::VISIBILITY_MASK) {
                    mesh.visibility_mask()
                } else {
                    DEFAULT_VISIBILITY_MASK
                },
            };
            let pipeline = if active.demand().contains(demand) {
                pipelines.specialize(&lookup, entity, &mesh, *view_key, shader, output)
            } else {
                None
            };
            let Some(pipeline) = pipeline.filter(|pipeline| pipelines.is_ready(*pipeline)) else {
                bevy_phases.add_deferred_as_forward(view, entity, &mesh, phase_type);
                pending.current_frame.insert((*render_entity, entity));
                continue;
            };

            if output.writes_motion && lookup.awaits_previous_morph(entity, &mesh) {
                pending.current_frame.insert((*render_entity, entity));
            }
            bevy_phases.remove(view, entity, active.keeps_prepass);
            phases.remove(&retained, entity);
            phases.add(
                &retained,
                alpha_masked,
                extended,
                QueuedMesh {
                    targets,
                    pipeline,
                    draw_function: draw_functions.get(extended, alpha_masked),
                    material_bind_group_index: Some(mesh.material.binding.group.0),
                    slabs: mesh.slabs,
                    lightmap_slab: mesh.instance.lightmap_slab_index(),
                    mesh: mesh.instance.mesh_asset_id(),
                    entities: (*render_entity, entity),
                    uniform_index: mesh.instance.current_uniform_index,
                    phase_type,
                },
            );
        }
    }
    pending_queues.0.expire_stale_views(&live_views);
    demands.retain(|view| live_views.contains(view));
}
