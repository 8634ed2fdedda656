//! Sorts the meshes of a lean view before Bevy queues them: into the G-buffer, or left to Bevy's phases.
//!
//! A mesh is sorted when Bevy queues it (it became visible or changed), when a change of its components changed its
//! needs ([`ChangedMeshes`]), when it was not ready before, and when its view changed in a way that concerns it.
//! Otherwise its phase retains it.

use bevy::{
    mesh::Mesh3d,
    pbr::{
        MeshPipelineKey, PendingMeshMaterialQueues, PendingPrepassMeshMaterialQueues, ViewKeyCache,
    },
    platform::collections::{HashMap, HashSet},
    prelude::*,
    render::{
        batching::gpu_preprocessing::GpuPreprocessingSupport,
        camera::{DirtySpecializations, PendingQueues},
        render_phase::BinnedRenderPhaseType,
        render_resource::CachedRenderPipelineId,
        sync_world::{MainEntity, MainEntityHashSet},
        view::{ExtractedView, RenderVisibleEntities, RetainedViewEntity},
    },
};

use super::{
    bevy::{
        forward_pipelines::ForwardPipelines,
        phases::{BevyPhases, BevyViewPhases},
        pipeline_filter::{BevyPipelines, PipelineFilter, PipelineFilterWriter},
        queue_rules::{is_for_deferred_pass, keep_visible_in_order, visible_pair},
    },
    demand::{ViewDemand, ViewDemands},
    draw_functions::GBufferDrawFunctions,
    forward_meshes::{CameraForwardMeshes, ForwardMeshes},
    forward_reason::ForwardReason,
    left_meshes::{LeftMeshes, ViewLeftMeshes},
    lookup::{MeshLookup, MeshToQueue, RecentKinds},
    mesh_overrides::ChangedMeshes,
    phase::{GBufferPhases, GBufferViewPhases},
    phase_item::QueuedMesh,
    placement::{MeshOutput, Placement, ViewChange},
    specialize::{GBufferPipeline, GBufferPipelines, MeshKindKey, kind_key},
    stand_in::StandIns,
};
use crate::view::{ActiveLeanView, GBufferTargets, LeanDeferred};

/// Meshes whose assets or pipelines were not ready. They are retried each frame and drawn by forward until then.
#[derive(Resource, Default)]
pub(super) struct PendingGBufferQueues(PendingQueues);

/// In the render world: number of meshes that lean views sorted in this frame, into the G-buffer or out of it. 0 while
/// nothing changes; a change of a view counts only the meshes that it concerns.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SortedMeshes(pub usize);

/// Owner of a mesh before it is sorted.
#[derive(Clone, Copy, PartialEq, Eq)]
enum QueueOwner {
    /// None: the mesh changed or became visible, and Bevy queues it in this frame if it is offered.
    Nobody,
    /// Bevy: the mesh is in its phases, or Bevy waits for it.
    Bevy,
    /// Bevy or the G-buffer.
    Either,
}

/// Moves the meshes that the G-buffer draws into its phases and leaves the others to Bevy; runs before Bevy's own queue
/// systems.
///
/// A mesh that needs more than its view has is left to forward and its need is recorded. The view meets it from a later
/// frame on, once lighting is compiled for it and the pipelines of all other meshes are: see `demand.rs`.
pub(super) fn queue_gbuffer_meshes(
    lookup: MeshLookup,
    mut pipelines: GBufferPipelines,
    (mut bevy_phases, bevy_pipelines, mut pipeline_filter, mut forward_pipelines): (
        BevyPhases,
        BevyPipelines,
        ResMut<PipelineFilter>,
        ResMut<ForwardPipelines>,
    ),
    mut phases: GBufferPhases,
    (mut pending_queues, mut demands, mut forward_meshes, mut left, mut count): (
        ResMut<PendingGBufferQueues>,
        ResMut<ViewDemands>,
        ResMut<ForwardMeshes>,
        ResMut<LeftMeshes>,
        ResMut<SortedMeshes>,
    ),
    mut draw_functions: GBufferDrawFunctions,
    (view_keys, dirty, changed, gpu_preprocessing, bevy_pending, bevy_prepass_pending): (
        Res<ViewKeyCache>,
        Res<DirtySpecializations>,
        Res<ChangedMeshes>,
        Res<GpuPreprocessingSupport>,
        Res<PendingMeshMaterialQueues>,
        Res<PendingPrepassMeshMaterialQueues>,
    ),
    views: Query<
        (
            &ExtractedView,
            &RenderVisibleEntities,
            Option<&ActiveLeanView>,
        ),
        With<LeanDeferred>,
    >,
    cameras: Query<&MainEntity, With<LeanDeferred>>,
    mut live_views: Local<HashSet<RetainedViewEntity>>,
    mut sorted: Local<HashMap<RetainedViewEntity, SortedView>>,
    (mut concerned, mut sorted_now, mut kinds_for_forward, mut stand_ins): (
        Local<Vec<MainEntity>>,
        Local<MainEntityHashSet>,
        Local<HashSet<MeshKindKey>>,
        Local<StandIns>,
    ),
) {
    live_views.clear();
    left.start_frame();
    pipelines.start_frame();
    if pipelines.are_of_another_device() {
        sorted.clear();
        forward_pipelines.clear();
    }
    count.0 = 0;
    let mut recent_kinds = RecentKinds::default();

    for (view, visible_entities, active) in &views {
        let retained = view.retained_view_entity;
        let (Some(phases), Some(view_key), Some(visible)) = (
            phases.of(&retained),
            view_keys.get(&retained),
            visible_entities.get::<Mesh3d>(),
        ) else {
            continue;
        };
        live_views.insert(retained);
        let pending = pending_queues.0.prepare_for_new_frame(retained);
        let mut waiting: Vec<_> = pending.prev_frame.drain().collect();
        let is_new = !sorted.contains_key(&retained);
        if is_new {
            // Meshes that Bevy has waited for since before the camera was lean.
            for queues in [&bevy_pending.0, &bevy_prepass_pending.0] {
                let former = queues.get(&retained).map(|queue| &queue.prev_frame);
                waiting.extend(former.into_iter().flatten());
            }
        }
        let sorted = sorted.entry(retained).or_default();
        let former = core::mem::replace(&mut sorted.active, active.copied());
        kinds_for_forward.clear();
        stand_ins.clear();
        concerned.clear();
        sorted_now.clear();
        let stood_in = core::mem::take(&mut sorted.look_again);
        concerned.extend(changed.iter().chain(stood_in.iter().copied()));
        let shader_has_changed =
            (sorted.pipelines.iter()).any(|(id, state_then)| pipelines.state(*id) != *state_then);
        let mut sorter = Sorter {
            lookup: &lookup,
            recent_kinds: &mut recent_kinds,
            pipelines: &mut pipelines,
            draw_functions: &mut draw_functions,
            gpu_preprocessing: &gpu_preprocessing,
            draws_deferred: bevy_phases.draws_deferred(&retained),
            bevy: bevy_phases.of(&retained),
            forward_pipelines: &mut forward_pipelines,
            kinds_for_forward: &mut kinds_for_forward,
            stand_ins: &mut stand_ins,
            filter: pipeline_filter.of(retained, &bevy_pipelines),
            phases,
            pending: &mut pending.current_frame,
            sorted: &mut sorted_now,
            looked_at_again: &stood_in,
            look_again: &mut sorted.look_again,
            known_pipelines: &mut sorted.pipelines,
            demand: demands.of(retained),
            forward_meshes: forward_meshes.of(retained.main_entity, active.is_some()),
            left: left.of(retained),
            view: retained,
            view_key: *view_key,
            active,
            targets_are_guessed: former.is_none(),
            count: &mut count.0,
        };
        for &entity in dirty.iter_to_dequeue(retained, visible) {
            sorter.phases.remove(entity);
            sorter.demand.remove(entity);
            sorter.left.removed.push(entity);
            sorter.forget_forward_reason(entity);
        }

        let change = ViewChange::between(former.as_ref(), active);
        let queues_all = dirty.must_wipe_specializations_for_view(retained);
        let lacks_reasons = match &sorter.forward_meshes {
            Some(meshes) => !meshes.is_complete(),
            None => false,
        };
        if queues_all {
            sorter.forward_pipelines.forget_waiting(retained);
        }
        if change == ViewChange::All || queues_all || shader_has_changed || lacks_reasons {
            sorter.known_pipelines.clear();
            if let Some(meshes) = &mut sorter.forward_meshes {
                meshes.start_over();
            }
            let owner = if queues_all {
                QueueOwner::Nobody
            } else {
                QueueOwner::Either
            };
            for pair in visible.iter_visible() {
                sorter.sort(pair, owner);
            }
            sorter.prepare_next_targets(visible);
            continue;
        }
        for pair in dirty.iter_to_queue(retained, visible, &HashSet::default()) {
            sorter.sort(pair, QueueOwner::Nobody);
        }
        keep_visible_in_order(&mut waiting, visible);
        for (render_entity, entity) in &waiting {
            sorter.sort((render_entity, entity), QueueOwner::Bevy);
        }
        if let (ViewChange::Demand, Some(former), Some(active)) = (change, &former, active) {
            let demands = sorter.demand.each();
            concerned.extend(demands.filter_map(|(mesh, demand)| {
                (Placement::of(demand, former) != Placement::of(demand, active)).then_some(mesh)
            }));
        }
        let owner = match former {
            Some(_) => QueueOwner::Either,
            None => QueueOwner::Bevy,
        };
        for &mesh in &concerned {
            if let Some(pair) = visible_pair(visible, mesh) {
                sorter.sort((&pair.0, &pair.1), owner);
            }
        }
        sorter.prepare_next_targets(visible);
    }
    pipeline_filter.keep_only(&live_views);
    forward_pipelines.keep_only(|view| live_views.contains(view));
    pending_queues.0.expire_stale_views(&live_views);
    forward_meshes.keep_only(|camera| live_views.iter().any(|view| view.main_entity == camera));
    left.keep_only(|view| live_views.contains(view));
    sorted.retain(|view, _| live_views.contains(view));
    demands.retain(
        |view| live_views.contains(view),
        |view| cameras.iter().any(|camera| *camera == view.main_entity),
    );
}

/// State with which the meshes of a view were last sorted.
#[derive(Default)]
pub(super) struct SortedView {
    active: Option<ActiveLeanView>,
    /// Meshes that need another pipeline in the next frame.
    look_again: MainEntityHashSet,
    /// The pipelines and their states. After a shader change they are compiled again, and may newly fail or succeed.
    pipelines: HashMap<CachedRenderPipelineId, GBufferPipeline>,
}

/// Sorts the meshes of one view.
pub(super) struct Sorter<'a, 'l, 'w, 's, 'dw, 'ds> {
    pub(super) lookup: &'l MeshLookup<'l>,
    pub(super) recent_kinds: &'a mut RecentKinds<'l>,
    pub(super) pipelines: &'a mut GBufferPipelines<'w, 's>,
    draw_functions: &'a mut GBufferDrawFunctions<'dw, 'ds>,
    gpu_preprocessing: &'a GpuPreprocessingSupport,
    /// True if Bevy's deferred pass draws into this view; the view is not lean then.
    draws_deferred: bool,
    bevy: BevyViewPhases<'a>,
    pub(super) forward_pipelines: &'a mut ForwardPipelines,
    /// Kinds of meshes whose pipeline of Bevy's was asked for in this frame.
    kinds_for_forward: &'a mut HashSet<MeshKindKey>,
    pub(super) stand_ins: &'a mut StandIns,
    filter: PipelineFilterWriter<'a>,
    phases: GBufferViewPhases<'a>,
    pending: &'a mut HashSet<(Entity, MainEntity)>,
    /// Meshes that were sorted in this frame.
    sorted: &'a mut MainEntityHashSet,
    /// Those of the last frame's `look_again`.
    pub(super) looked_at_again: &'a MainEntityHashSet,
    look_again: &'a mut MainEntityHashSet,
    known_pipelines: &'a mut HashMap<CachedRenderPipelineId, GBufferPipeline>,
    pub(super) demand: &'a mut ViewDemand,
    /// `None` if nobody asks for them, or if the view is not lean.
    forward_meshes: Option<&'a mut CameraForwardMeshes>,
    left: &'a mut ViewLeftMeshes,
    view: RetainedViewEntity,
    pub(super) view_key: MeshPipelineKey,
    pub(super) active: Option<&'a ActiveLeanView>,
    /// The view was not lean in the last frame: its targets are those of other views.
    pub(super) targets_are_guessed: bool,
    count: &'a mut usize,
}

impl Sorter<'_, '_, '_, '_, '_, '_> {
    fn sort(&mut self, (&render_entity, &entity): (&Entity, &MainEntity), owner: QueueOwner) {
        let entities = (render_entity, entity);
        if !self.sorted.insert(entity) {
            return;
        }
        *self.count += 1;
        if owner != QueueOwner::Nobody {
            self.phases.remove(entity);
        }
        self.left.removed.push(entity);
        self.forget_forward_reason(entity);
        let lookup = self.lookup;
        let mesh = match lookup.find(entity, self.recent_kinds) {
            Ok(mesh) => mesh,
            Err(may_come) => {
                self.filter.leave(entities, true, false);
                if may_come {
                    self.pending.insert(entities);
                }
                return;
            }
        };
        let phase_type =
            BinnedRenderPhaseType::mesh(mesh.instance.should_batch(), self.gpu_preprocessing);
        let needs = lookup.gbuffer_needs(entity, &mesh);
        match &needs {
            Ok((demand, _)) => self.demand.insert(entity, *demand),
            Err(_) => self.demand.remove(entity),
        }
        let (demand, shaders, active) = match (needs, self.active) {
            (Ok((demand, shaders)), Some(active)) => (demand, shaders, active),
            (needs, _) => {
                self.leave_to_forward(entities, &mesh, owner, needs.err());
                return;
            }
        };

        let placement = Placement::of(demand, active);
        let mut output = placement.output;
        let mut pipeline = self.pipeline(entity, &mesh, shaders, placement);
        if matches!(pipeline, GBufferPipeline::Pending(_))
            && let Some((less, id)) = self.stand_in(entity, &mesh, shaders, demand, placement)
        {
            (output, pipeline) = (less, GBufferPipeline::Ready(id));
            self.look_again.insert(entity);
        }
        let is_drawn = matches!(pipeline, GBufferPipeline::Ready(_));
        self.prepare(entity, &mesh, shaders, demand, placement.output, is_drawn);
        if let GBufferPipeline::Ready(id) | GBufferPipeline::Failed(Some(id)) = pipeline {
            self.known_pipelines.insert(id, pipeline);
        }
        let GBufferPipeline::Ready(pipeline) = pipeline else {
            let reason = match pipeline {
                GBufferPipeline::Failed(_) => ForwardReason::PipelineFailed,
                _ => ForwardReason::Compiling,
            };
            self.leave_to_forward(entities, &mesh, owner, Some(reason));
            // An unmet demand needs no retry: the mesh is sorted again when the view changes.
            if matches!(pipeline, GBufferPipeline::Pending(_)) && placement.is_met() {
                self.pending.insert(entities);
            }
            return;
        };

        if output.targets.contains(GBufferTargets::MOTION) {
            if lookup.bevy.awaits_previous_morph(entity, &mesh.instance) {
                self.look_again.insert(entity);
            }
            if !mesh.deforms {
                // Compiled before it stops, or before the view has no motion vectors any more.
                let mut still = demand;
                still.demand.targets -= GBufferTargets::MOTION;
                let still = MeshOutput::of(still, active.targets, active.culls_in_two_phases);
                (self.pipelines).get(lookup, entity, &mesh, self.view_key, shaders, still);
            }
        }
        self.take_from_forward(entity, &mesh, active.keeps_prepass, owner);
        self.prepare_for_forward(entity, &mesh);
        let visibility_mask = output
            .targets
            .contains(GBufferTargets::VISIBILITY_MASK)
            .then(|| lookup.special_meshes.visibility_mask(entity));
        let draw_function =
            self.draw_functions
                .get(output, demand.is_alpha_masked, visibility_mask);
        self.phases.add(
            demand.is_alpha_masked,
            output.is_extended(),
            QueuedMesh {
                visibility_mask,
                pipeline,
                draw_function,
                material_bind_group_index: Some(mesh.material.binding.group.0),
                slabs: mesh.slabs,
                lightmap_slab: mesh.instance.lightmap_slab_index(),
                mesh: mesh.instance.mesh_asset_id(),
                entities,
                uniform_index: mesh.instance.current_uniform_index,
                phase_type,
            },
        );
    }

    /// True if the mesh's method is `Deferred` but the view has no deferred pass of Bevy's: Bevy must not queue it.
    fn is_strange_to_bevy(&self, mesh: &MeshToQueue) -> bool {
        !self.draws_deferred && is_for_deferred_pass(&mesh.material.properties)
    }

    fn forget_forward_reason(&mut self, entity: MainEntity) {
        if let Some(meshes) = &mut self.forward_meshes {
            meshes.remove(entity);
        }
    }

    /// `reason` is `None` if the view is not lean: forward draws all its meshes.
    fn leave_to_forward(
        &mut self,
        entities: (Entity, MainEntity),
        mesh: &MeshToQueue,
        owner: QueueOwner,
        reason: Option<ForwardReason>,
    ) {
        let entity = entities.1;
        if let (Some(meshes), Some(reason)) = (&mut self.forward_meshes, reason) {
            meshes.insert(entity, mesh.material_id, reason);
        }
        if reason.is_some_and(|reason| reason != ForwardReason::Compiling) && self.active.is_some()
        {
            self.left.left.push(entity);
        }
        let is_strange = self.is_strange_to_bevy(mesh);
        let is_forced = is_strange || owner == QueueOwner::Either;
        self.filter.leave(entities, !is_strange, is_forced);
    }

    /// Requests Bevy's pipeline of a mesh, in the background.
    fn prepare_for_forward(&mut self, entity: MainEntity, mesh: &MeshToQueue) {
        if !self.pipelines.compile_in_background() {
            return;
        }
        let kind = kind_key(self.lookup, entity, mesh);
        if self.kinds_for_forward.insert(kind) {
            let view = (self.view, self.view_key);
            (self.forward_pipelines).compile_later(self.lookup, entity, mesh, view);
        }
    }

    /// Keeps the mesh in Bevy's prepass if the G-buffer does not write everything that the prepass writes.
    fn take_from_forward(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        keeps_prepass: bool,
        owner: QueueOwner,
    ) {
        if owner != QueueOwner::Nobody {
            self.bevy.take_out(entity, keeps_prepass);
        }
        if !keeps_prepass {
            return;
        }
        let is_strange = self.is_strange_to_bevy(mesh);
        if !is_strange {
            self.filter.add_to_prepass(entity);
        }
        if is_strange || owner == QueueOwner::Either {
            self.filter.force_into_prepass(entity);
        }
    }
}
