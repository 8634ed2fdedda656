//! Prepares the meshes of a view for the targets that it should have next. See `demand.rs`.

use bevy::{
    platform::collections::HashSet,
    render::{sync_world::MainEntity, view::RenderVisibleEntitiesClass},
};

use super::{
    demand::NextTargets,
    lookup::MeshToQueue,
    placement::{MeshDemand, MeshOutput, Placement},
    queue::Sorter,
    registration::MaterialShaders,
    specialize::GBufferPipeline,
};

impl Sorter<'_, '_, '_, '_, '_, '_> {
    /// The pipeline that draws a mesh; also requested while lighting for it is not compiled.
    pub(super) fn pipeline(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        shaders: &MaterialShaders,
        placement: Placement,
    ) -> GBufferPipeline {
        if !placement.has_targets {
            return GBufferPipeline::Pending(None);
        }
        let output = placement.output;
        let pipeline =
            (self.pipelines).get(self.lookup, entity, mesh, self.view_key, shaders, output);
        if placement.is_lit {
            pipeline
        } else {
            GBufferPipeline::Pending(None)
        }
    }

    /// Requests the pipeline that draws a mesh once the view has its next targets, which wait for it if the mesh is
    /// drawn `now`. If these targets are fewer and the pipeline is new, the view keeps its targets, unless they are guessed.
    pub(super) fn prepare(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        shaders: &MaterialShaders,
        demand: MeshDemand,
        now: MeshOutput,
        is_drawn: bool,
    ) {
        let (Some(active), Some(next)) = (self.active, &mut self.demand.next) else {
            return;
        };
        let output = MeshOutput::of(demand, next.targets, active.culls_in_two_phases);
        if output == now || !(is_drawn || next.is_growth) {
            return;
        }
        let (lookup, view_key) = (self.lookup, self.view_key);
        if !next.is_growth
            && !self.targets_are_guessed
            && !(self.pipelines).knows(lookup, entity, mesh, view_key, shaders, output)
        {
            self.demand.keep_targets();
            return;
        }
        let pipeline = (self.pipelines).get(lookup, entity, mesh, view_key, shaders, output);
        if let GBufferPipeline::Pending(Some(id)) = pipeline
            && is_drawn
        {
            next.awaited.insert(id);
        }
    }

    /// Prepares all meshes for the next targets if these have changed. Meshes that are sorted later are prepared then.
    pub(super) fn prepare_next_targets(&mut self, visible: &RenderVisibleEntitiesClass) {
        let Some(active) = self.active else {
            self.demand.next = None;
            return;
        };
        let next = self.demand.next_targets(active);
        if next == self.demand.next.as_ref().map(|next| next.targets) {
            return;
        }
        self.demand.next = next.map(|targets| NextTargets {
            targets,
            is_growth: !active.targets.contains(targets),
            awaited: HashSet::default(),
        });
        let Some(targets) = next else {
            return;
        };
        let concerns_all =
            active.culls_in_two_phases && active.targets.is_empty() != targets.is_empty();
        let meshes: Vec<MainEntity> = if concerns_all {
            visible.iter_visible().map(|(_, mesh)| *mesh).collect()
        } else {
            self.demand.each().map(|(mesh, _)| mesh).collect()
        };
        let lookup = self.lookup;
        for entity in meshes {
            let Ok(mesh) = lookup.find(entity, self.recent_kinds) else {
                continue;
            };
            let needs = lookup.gbuffer_needs(entity, &mesh);
            let Ok((demand, shaders)) = needs else {
                continue;
            };
            let placement = Placement::of(demand, active);
            let pipeline = self.pipeline(entity, &mesh, shaders, placement);
            let is_drawn = match pipeline {
                GBufferPipeline::Ready(_) => true,
                GBufferPipeline::Pending(_) => {
                    let stand_in = self.stand_in(entity, &mesh, shaders, demand, placement);
                    stand_in.is_some()
                }
                GBufferPipeline::Failed(_) => false,
            };
            self.prepare(entity, &mesh, shaders, demand, placement.output, is_drawn);
        }
    }
}
