//! Limits the meshes of a lean view that Bevy's queue systems see to those that Bevy draws.
//!
//! Bevy queues a mesh with its specialized pipeline and skips meshes without one. While Bevy's queue systems run, each
//! lean view exposes only the pipelines of meshes left to Bevy; the others are set aside. So no mesh enters
//! a phase of Bevy's only to be removed again. `forward_pipelines.rs` specializes those that are missing.

use bevy::{
    ecs::system::SystemParam,
    pbr::{
        SpecializedMaterialPipelineCache, SpecializedMaterialViewPipelineCache,
        SpecializedPrepassMaterialPipelineCache, SpecializedPrepassMaterialViewPipelineCache,
    },
    platform::collections::{HashMap, HashSet},
    prelude::*,
    render::{
        batching::gpu_preprocessing::GpuPreprocessingSupport, render_phase::BinnedRenderPhaseType,
        render_resource::CachedRenderPipelineId, sync_world::MainEntity, view::RetainedViewEntity,
    },
};

use super::phases::BevyPhases;
use crate::gbuffer::lookup::{MeshLookup, RecentKinds};

/// The pipelines that Bevy specialized for all views.
#[derive(SystemParam)]
pub(in crate::gbuffer) struct BevyPipelines<'w> {
    main: ResMut<'w, SpecializedMaterialPipelineCache>,
    prepass: ResMut<'w, SpecializedPrepassMaterialPipelineCache>,
}

/// Pipelines that Bevy may queue in this frame, per lean view. While Bevy queues, it contains the withheld ones
/// instead.
#[derive(Resource, Default)]
pub(in crate::gbuffer) struct PipelineFilter(HashMap<RetainedViewEntity, ViewPipelines>);

#[derive(Default)]
struct ViewPipelines {
    main: SpecializedMaterialViewPipelineCache,
    prepass: SpecializedPrepassMaterialViewPipelineCache,
    /// Meshes that Bevy would not queue; added to its phases after it has queued its own.
    forced: Vec<Forced>,
    missing: Vec<MissingPipeline>,
}

/// A mesh whose main-pass pipeline is not specialized yet.
pub(in crate::gbuffer) struct MissingPipeline {
    pub(in crate::gbuffer) entities: (Entity, MainEntity),
    /// Bevy is to see the pipeline.
    pub(in crate::gbuffer) is_shown: bool,
}

/// A mesh that is added to Bevy's prepass, if the view has one, although Bevy does not queue it.
struct Forced {
    mesh: MainEntity,
    /// Adds it to the main phases too.
    into_main: bool,
}

impl ViewPipelines {
    /// Swaps these pipelines with those that Bevy sees.
    fn swap(&mut self, view: &RetainedViewEntity, pipelines: &mut BevyPipelines) {
        if let Some(main) = pipelines.main.get_mut(view) {
            core::mem::swap(main, &mut self.main);
        }
        if let Some(prepass) = pipelines.prepass.get_mut(view) {
            core::mem::swap(prepass, &mut self.prepass);
        }
    }
}

impl PipelineFilter {
    /// Adds meshes to the filter of `view`.
    pub(in crate::gbuffer) fn of<'a>(
        &'a mut self,
        view: RetainedViewEntity,
        pipelines: &'a BevyPipelines,
    ) -> PipelineFilterWriter<'a> {
        PipelineFilterWriter {
            main: pipelines.main.get(&view),
            prepass: pipelines.prepass.get(&view),
            pipelines: self.0.entry(view).or_default(),
        }
    }

    /// Drops views that are not in `views`.
    pub(in crate::gbuffer) fn keep_only(&mut self, views: &HashSet<RetainedViewEntity>) {
        self.0.retain(|view, _| views.contains(view));
    }

    /// Returns the meshes of each view that lack pipelines.
    pub(super) fn take_missing(
        &mut self,
    ) -> impl Iterator<Item = (RetainedViewEntity, impl Iterator<Item = MissingPipeline>)> {
        (self.0.iter_mut()).map(|(view, filtered)| (*view, filtered.missing.drain(..)))
    }

    /// Lets Bevy queue a mesh whose pipeline was missing.
    pub(super) fn show_mesh(
        &mut self,
        view: RetainedViewEntity,
        mesh: MainEntity,
        pipeline: CachedRenderPipelineId,
    ) {
        let filtered = self.0.entry(view).or_default();
        filtered.main.insert(mesh, pipeline);
    }
}

/// True if pipelines of meshes left to Bevy are missing.
pub(in crate::gbuffer) fn pipelines_are_missing(filter: Res<PipelineFilter>) -> bool {
    filter.0.values().any(|view| !view.missing.is_empty())
}

/// Exposes only the pipelines of the filter to Bevy.
pub(in crate::gbuffer) fn filter_pipelines(
    mut pipelines: BevyPipelines,
    mut filter: ResMut<PipelineFilter>,
) {
    for (view, filtered) in &mut filter.0 {
        filtered.swap(view, &mut pipelines);
    }
}

/// Adds meshes to the filter of one view.
pub(in crate::gbuffer) struct PipelineFilterWriter<'a> {
    main: Option<&'a SpecializedMaterialViewPipelineCache>,
    prepass: Option<&'a SpecializedPrepassMaterialViewPipelineCache>,
    pipelines: &'a mut ViewPipelines,
}

impl PipelineFilterWriter<'_> {
    /// Leaves the mesh to Bevy, which sees it if it `is_shown`. If it `is_forced`, it is added to Bevy's phases although Bevy does not
    /// queue it.
    pub(in crate::gbuffer) fn leave(
        &mut self,
        entities: (Entity, MainEntity),
        is_shown: bool,
        is_forced: bool,
    ) {
        let mesh = entities.1;
        match self.main.and_then(|pipelines| pipelines.get(&mesh)) {
            Some(&pipeline) if is_shown => {
                self.pipelines.main.insert(mesh, pipeline);
            }
            Some(_) => {}
            None => (self.pipelines.missing).push(MissingPipeline { entities, is_shown }),
        }
        if is_shown {
            self.add_to_prepass(mesh);
        }
        if is_forced {
            self.pipelines.forced.push(Forced {
                mesh,
                into_main: true,
            });
        }
    }

    /// Lets Bevy queue the mesh for its prepass alone.
    pub(in crate::gbuffer) fn add_to_prepass(&mut self, mesh: MainEntity) {
        if let Some(&pipeline) = self.prepass.and_then(|pipelines| pipelines.get(&mesh)) {
            self.pipelines.prepass.insert(mesh, pipeline);
        }
    }

    /// Adds the mesh to Bevy's prepass although Bevy does not queue it.
    pub(in crate::gbuffer) fn force_into_prepass(&mut self, mesh: MainEntity) {
        self.pipelines.forced.push(Forced {
            mesh,
            into_main: false,
        });
    }
}

/// Restores Bevy's pipelines after its queue systems, and adds the forced meshes to its phases.
pub(in crate::gbuffer) fn restore_pipelines(
    lookup: MeshLookup,
    gpu_preprocessing: Res<GpuPreprocessingSupport>,
    mut pipelines: BevyPipelines,
    mut bevy_phases: BevyPhases,
    mut filter: ResMut<PipelineFilter>,
) {
    let mut kinds = RecentKinds::default();
    for (view, filtered) in &mut filter.0 {
        filtered.swap(view, &mut pipelines);
        filtered.main.clear();
        filtered.prepass.clear();
        let mut phases = bevy_phases.of(view);
        let (main, prepass) = (pipelines.main.get(view), pipelines.prepass.get(view));
        for Forced { mesh, into_main } in filtered.forced.drain(..) {
            let Ok(found) = lookup.find(mesh, &mut kinds) else {
                continue;
            };
            let phase_type =
                BinnedRenderPhaseType::mesh(found.instance.should_batch(), &gpu_preprocessing);
            // Without a pipeline, Bevy waits for it too and then queues the mesh.
            let pipeline = main.filter(|_| into_main).and_then(|main| main.get(&mesh));
            if let Some(&pipeline) = pipeline {
                phases.put_into_main(mesh, &found, phase_type, pipeline, None);
            }
            if let Some(prepass) = prepass {
                phases.put_into_prepass(mesh, &found, phase_type, prepass);
            }
        }
    }
}
