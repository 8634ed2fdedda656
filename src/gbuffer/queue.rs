//! Sorts the meshes of a lean view: into the G-buffer, out of Bevy's forward phases, or left to those.

use bevy::{
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
        DrawPrepass, MainPassOpaqueDrawFunction, MeshPipelineKey, PrepassPipeline,
        RenderMeshInstanceFlags, SpecializedMaterialPipelineCache, ViewKeyCache,
        alpha_mode_pipeline_key,
    },
    platform::collections::HashSet,
    prelude::*,
    render::{
        batching::gpu_preprocessing::GpuPreprocessingSupport,
        camera::{DirtySpecializations, PendingQueues},
        render_phase::{
            BinnedRenderPhaseType, DrawFunctionId, DrawFunctions, ViewBinnedRenderPhases,
        },
        render_resource::{CachedRenderPipelineId, PipelineCache, SpecializedMeshPipelines},
        sync_world::MainEntity,
        view::{ExtractedView, RenderVisibleEntities, RetainedViewEntity},
    },
};

use super::{
    demand::ViewDemands,
    layout::DEFAULT_VISIBILITY_MASK,
    lookup::{MeshLookup, MeshToQueue},
    phase::{
        AlphaMaskGBuffer, ExtendedAlphaMaskGBuffer, ExtendedOpaqueGBuffer, GBufferPhases,
        OpaqueGBuffer, QueuedMesh,
    },
    pipeline::{GBufferPipelineSpecializer, MeshOutput, VIEW_KEY_BITS},
    targets::GBufferTargets,
};
use crate::{LeanDeferred, camera::ActiveLeanView};

/// Meshes whose assets or pipelines were not ready; tried again each frame, drawn by forward until then.
#[derive(Resource, Default)]
pub(super) struct PendingGBufferQueues(PendingQueues);

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
