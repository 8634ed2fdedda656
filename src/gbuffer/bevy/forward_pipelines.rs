//! Specializes Bevy's main-pass pipelines for the meshes of lean views.
//!
//! Bevy specializes one for each mesh that becomes visible or changes. On views that could be lean this crate does so in its place, once
//! it is known which meshes are left to Bevy. Bevy's system skips views without main phases, so these are set aside while it runs.
//!
//! Pipelines of meshes in the G-buffer are compiled one at a time, while no others are: if such a mesh is left to Bevy, it must not
//! vanish until its pipeline is compiled. Where Bevy compiles within the frame they are not: each would delay a frame, and all of them
//! take longer than all pipelines of this crate.

use alloc::{collections::VecDeque, sync::Arc};
use core::hash::BuildHasher;

use bevy::{
    core_pipeline::core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
    ecs::system::SystemState,
    material::{MaterialProperties, key::ErasedMaterialPipelineKey},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{
        MeshPipelineKey, PendingMeshMaterialQueues, SpecializedMaterialPipelineCache,
        Transmissive3d, ViewKeyCache, alpha_mode_pipeline_key,
    },
    platform::{
        collections::{HashMap, HashSet},
        hash::FixedHasher,
    },
    prelude::*,
    render::{
        camera::DirtySpecializations,
        render_phase::{
            BinnedRenderPhase, SortedRenderPhase, ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
        render_resource::{CachedRenderPipelineId, PipelineCache},
        sync_world::MainEntity,
        view::{ExtractedView, RetainedViewEntity},
    },
};

use super::pipeline_filter::{MissingPipeline, PipelineFilter};
use crate::{
    gbuffer::{
        lookup::{MeshLookup, MeshToQueue, RecentKinds},
        phase::GBufferPhases,
        specialize::{PREVIOUS, instance_key, material_pipeline_key},
    },
    gpu::named::system_param,
    view::LeanDeferred,
};

system_param! {
    /// Bevy's main phases of all views.
    pub(in crate::gbuffer) struct MainPhases<'w> {
        opaque: ResMut<'w, ViewBinnedRenderPhases<Opaque3d>>,
        alpha_mask: ResMut<'w, ViewBinnedRenderPhases<AlphaMask3d>>,
        transmissive: ResMut<'w, ViewSortedRenderPhases<Transmissive3d>>,
        transparent: ResMut<'w, ViewSortedRenderPhases<Transparent3d>>,
    }
}

/// The main phases of a view. Bevy keeps all four for a view, or none.
type MainPhasesOfView = (
    BinnedRenderPhase<Opaque3d>,
    BinnedRenderPhase<AlphaMask3d>,
    SortedRenderPhase<Transmissive3d>,
    SortedRenderPhase<Transparent3d>,
);

impl MainPhases<'_> {
    fn take(&mut self, view: &RetainedViewEntity) -> Option<MainPhasesOfView> {
        let has_all = self.opaque.contains_key(view)
            && self.alpha_mask.contains_key(view)
            && self.transmissive.contains_key(view)
            && self.transparent.contains_key(view);
        if !has_all {
            return None;
        }
        Some((
            self.opaque.remove(view)?,
            self.alpha_mask.remove(view)?,
            self.transmissive.remove(view)?,
            self.transparent.remove(view)?,
        ))
    }

    fn put_back(&mut self, view: RetainedViewEntity, phases: MainPhasesOfView) {
        let (opaque, alpha_mask, transmissive, transparent) = phases;
        self.opaque.insert(view, opaque);
        self.alpha_mask.insert(view, alpha_mask);
        self.transmissive.insert(view, transmissive);
        self.transparent.insert(view, transparent);
    }
}

/// Main phases that are set aside while Bevy specializes.
#[derive(Resource, Default)]
pub(in crate::gbuffer) struct WithheldMainPhases(Vec<(RetainedViewEntity, MainPhasesOfView)>);

/// Sets the main phases aside of the views that `queue_gbuffer_meshes` sorts.
pub(in crate::gbuffer) fn withhold_main_phases(
    mut phases: MainPhases,
    mut gbuffer_phases: GBufferPhases,
    view_keys: Res<ViewKeyCache>,
    mut withheld: ResMut<WithheldMainPhases>,
    views: Query<&ExtractedView, With<LeanDeferred>>,
) {
    for view in &views {
        let view = view.retained_view_entity;
        if gbuffer_phases.of(&view).is_some()
            && view_keys.contains_key(&view)
            && let Some(main) = phases.take(&view)
        {
            withheld.0.push((view, main));
        }
    }
}

/// Restores the main phases, and does the rest of what Bevy's system does before it specializes: drops the pipelines of meshes that
/// changed, and starts a new frame of its waiting meshes.
pub(in crate::gbuffer) fn restore_main_phases(
    mut phases: MainPhases,
    mut withheld: ResMut<WithheldMainPhases>,
    mut pipelines: ResMut<SpecializedMaterialPipelineCache>,
    mut pending: ResMut<PendingMeshMaterialQueues>,
    dirty: Res<DirtySpecializations>,
) {
    for (view, main) in withheld.0.drain(..) {
        phases.put_back(view, main);
        pending.prepare_for_new_frame(view);
        let pipelines = pipelines.entry(view).or_default();
        if dirty.must_wipe_specializations_for_view(view) {
            pipelines.clear();
        } else {
            for mesh in dirty.iter_to_despecialize() {
                pipelines.remove(mesh);
            }
        }
    }
}

/// A pipeline to specialize.
struct ForwardPipeline {
    key: ErasedMaterialPipelineKey,
    layout: MeshVertexBufferLayoutRef,
    properties: Arc<MaterialProperties>,
}

impl ForwardPipeline {
    fn of(
        lookup: &MeshLookup,
        entity: MainEntity,
        mesh: &MeshToQueue,
        view_key: MeshPipelineKey,
    ) -> Self {
        let key = forward_key(lookup, entity, mesh, view_key);
        Self {
            key: material_pipeline_key(mesh, key),
            layout: mesh.mesh.layout.clone(),
            properties: mesh.material.properties.clone(),
        }
    }

    fn hash(&self) -> u64 {
        FixedHasher.hash_one((&self.layout, &self.key))
    }

    fn specialize(&self, world: &mut World) -> Option<CachedRenderPipelineId> {
        let specialize = self.properties.base_specialize?;
        match specialize(world, self.key.clone(), &self.layout, &self.properties) {
            Ok(id) => {
                let mut pipelines = world.resource_mut::<ForwardPipelines>();
                pipelines.known.insert(self.hash(), id);
                Some(id)
            }
            Err(error) => {
                error!("{error}");
                None
            }
        }
    }
}

/// Bevy's pipelines for kinds of meshes on lean views.
#[derive(Resource, Default)]
pub(in crate::gbuffer) struct ForwardPipelines {
    /// Those that were specialized, by hash.
    known: HashMap<u64, CachedRenderPipelineId>,
    /// Pipelines of meshes in the G-buffer that were asked for, by view.
    asked: HashSet<(RetainedViewEntity, u64)>,
    /// Those of them that wait.
    waiting: VecDeque<(RetainedViewEntity, ForwardPipeline)>,
}

impl ForwardPipelines {
    /// Bevy's pipeline of a mesh, if it was specialized.
    pub(in crate::gbuffer) fn get(
        &self,
        lookup: &MeshLookup,
        entity: MainEntity,
        mesh: &MeshToQueue,
        view_key: MeshPipelineKey,
    ) -> Option<CachedRenderPipelineId> {
        let pipeline = ForwardPipeline::of(lookup, entity, mesh, view_key);
        self.known.get(&pipeline.hash()).copied()
    }

    /// Queues the pipeline of a mesh in the G-buffer for compilation in the background.
    pub(in crate::gbuffer) fn compile_later(
        &mut self,
        lookup: &MeshLookup,
        entity: MainEntity,
        mesh: &MeshToQueue,
        (view, view_key): (RetainedViewEntity, MeshPipelineKey),
    ) {
        let pipeline = ForwardPipeline::of(lookup, entity, mesh, view_key);
        let hash = pipeline.hash();
        if !self.known.contains_key(&hash) && self.asked.insert((view, hash)) {
            self.waiting.push_back((view, pipeline));
        }
    }

    /// Drops the queued pipelines of a view whose key has changed.
    pub(in crate::gbuffer) fn forget_waiting(&mut self, view: RetainedViewEntity) {
        self.keep_only(|other| *other != view);
    }

    /// Drops the queued pipelines of other views.
    pub(in crate::gbuffer) fn keep_only(&mut self, is_kept: impl Fn(&RetainedViewEntity) -> bool) {
        self.asked.retain(|(view, _)| is_kept(view));
        self.waiting.retain(|(view, _)| is_kept(view));
    }

    /// Forgets the pipelines of a former device.
    pub(in crate::gbuffer) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Takes the next queued pipeline that is not specialized.
    fn next(&mut self) -> Option<ForwardPipeline> {
        loop {
            let (_, pipeline) = self.waiting.pop_front()?;
            if !self.known.contains_key(&pipeline.hash()) {
                return Some(pipeline);
            }
        }
    }
}

/// Frames for which a queued pipeline waits for others: one whose shader nothing provides is never compiled.
const PATIENCE: u32 = 60;

/// Specializes a queued pipeline of meshes in the G-buffer while none is compiling.
pub(in crate::gbuffer) fn compile_waiting_pipelines(world: &mut World, mut waited: Local<u32>) {
    let cache = world.resource::<PipelineCache>();
    if cache.waiting_pipelines().next().is_some() && *waited < PATIENCE {
        *waited += 1;
        return;
    }
    *waited = 0;
    if let Some(pipeline) = world.resource_mut::<ForwardPipelines>().next() {
        pipeline.specialize(world);
    }
}

/// True if pipelines of meshes in the G-buffer are to be compiled.
pub(in crate::gbuffer) fn pipelines_wait(pipelines: Res<ForwardPipelines>) -> bool {
    !pipelines.waiting.is_empty()
}

/// The pipeline of a mesh that is left to Bevy.
pub(in crate::gbuffer) struct LeftMesh {
    view: RetainedViewEntity,
    mesh: MainEntity,
    is_shown: bool,
    pipeline: ForwardPipeline,
}

system_param! {
    pub(in crate::gbuffer) struct ForwardPipelineInputs<'w> {
        lookup: MeshLookup<'w>,
        view_keys: Res<'w, ViewKeyCache>,
        pending: ResMut<'w, PendingMeshMaterialQueues>,
        filter: ResMut<'w, PipelineFilter>,
    }
}

/// Specializes the pipelines of meshes that are left to Bevy and have none. Has Bevy wait for meshes that are not ready.
pub(in crate::gbuffer) fn specialize_left_meshes(
    world: &mut World,
    state: &mut SystemState<ForwardPipelineInputs<'static>>,
    mut missing: Local<Vec<LeftMesh>>,
) {
    {
        let Ok(inputs) = state.get_mut(world) else {
            return;
        };
        let ForwardPipelineInputs {
            lookup,
            view_keys,
            mut pending,
            mut filter,
        } = inputs;
        let mut kinds = RecentKinds::default();
        for (view, meshes) in filter.take_missing() {
            let Some(view_key) = view_keys.get(&view) else {
                continue;
            };
            for MissingPipeline { entities, is_shown } in meshes {
                let mesh = entities.1;
                match lookup.find(mesh, &mut kinds) {
                    Ok(found) => missing.push(LeftMesh {
                        view,
                        mesh,
                        is_shown,
                        pipeline: ForwardPipeline::of(&lookup, mesh, &found, *view_key),
                    }),
                    Err(true) => {
                        let pending = pending.entry(view).or_default();
                        pending.current_frame.insert(entities);
                    }
                    Err(false) => {}
                }
            }
        }
    }
    for left in missing.drain(..) {
        let Some(id) = left.pipeline.specialize(world) else {
            continue;
        };
        let mut pipelines = world.resource_mut::<SpecializedMaterialPipelineCache>();
        let pipelines = pipelines.entry(left.view).or_default();
        pipelines.insert(left.mesh, id);
        if left.is_shown {
            let mut filter = world.resource_mut::<PipelineFilter>();
            filter.show_mesh(left.view, left.mesh, id);
        }
    }
}

/// Key bits of Bevy's main-pass pipeline of a mesh.
fn forward_key(
    lookup: &MeshLookup,
    entity: MainEntity,
    mesh: &MeshToQueue,
    view_key: MeshPipelineKey,
) -> MeshPipelineKey {
    let properties = &mesh.material.properties;
    let material: MeshPipelineKey = properties.mesh_pipeline_key_bits.downcast();
    let msaa = Msaa::from_samples(view_key.msaa_samples());
    let mut instance = instance_key(lookup, entity, mesh);
    if !view_key.contains(MeshPipelineKey::MOTION_VECTOR_PREPASS) {
        instance -= PREVIOUS;
    }
    view_key
        | material
        | alpha_mode_pipeline_key(properties.alpha_mode, &msaa)
        | MeshPipelineKey::from_bits_retain(mesh.mesh.key_bits.bits())
        | instance
}
