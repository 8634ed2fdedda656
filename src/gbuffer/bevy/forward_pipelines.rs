//! Specializes Bevy's pipelines for the meshes of lean views that Bevy draws, and for no others.
//!
//! Bevy specializes a main-pass pipeline for each mesh that becomes visible or changes. On views that could be lean this crate does so
//! in its place, once it is known which meshes are left to Bevy: compiling the others' pipelines would take longer than all of this
//! crate's. Bevy's system skips views without main phases, so these are set aside while it runs.

use alloc::sync::Arc;

use bevy::{
    core_pipeline::core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
    ecs::system::SystemState,
    material::{MaterialProperties, key::ErasedMaterialPipelineKey},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{
        MeshPipelineKey, PendingMeshMaterialQueues, SpecializedMaterialPipelineCache,
        Transmissive3d, ViewKeyCache, alpha_mode_pipeline_key,
    },
    prelude::*,
    render::{
        camera::DirtySpecializations,
        render_phase::{
            BinnedRenderPhase, SortedRenderPhase, ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
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
pub(in crate::gbuffer) struct ForwardPipeline {
    view: RetainedViewEntity,
    mesh: MainEntity,
    is_shown: bool,
    key: ErasedMaterialPipelineKey,
    layout: MeshVertexBufferLayoutRef,
    properties: Arc<MaterialProperties>,
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
    mut missing: Local<Vec<ForwardPipeline>>,
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
                    Ok(found) => missing.push(ForwardPipeline {
                        view,
                        mesh,
                        is_shown,
                        key: material_pipeline_key(
                            &found,
                            forward_key(&lookup, mesh, &found, *view_key),
                        ),
                        layout: found.mesh.layout.clone(),
                        properties: found.material.properties.clone(),
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
    for pipeline in missing.drain(..) {
        let Some(specialize) = pipeline.properties.base_specialize else {
            continue;
        };
        match specialize(world, pipeline.key, &pipeline.layout, &pipeline.properties) {
            Ok(id) => {
                let mut pipelines = world.resource_mut::<SpecializedMaterialPipelineCache>();
                let pipelines = pipelines.entry(pipeline.view).or_default();
                pipelines.insert(pipeline.mesh, id);
                if pipeline.is_shown {
                    let mut filter = world.resource_mut::<PipelineFilter>();
                    filter.show_mesh(pipeline.view, pipeline.mesh, id);
                }
            }
            Err(error) => error!("{error}"),
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
