//! Draws a mesh by a pipeline that writes less than the mesh needs, until the right one and its targets are ready.
//!
//! A mesh that begins to emit light or to move is left to Bevy until its new pipeline is compiled, if Bevy's is. Otherwise it would
//! vanish.

use bevy::{
    platform::collections::HashMap,
    render::{render_resource::CachedRenderPipelineId, sync_world::MainEntity},
};

use super::{
    lookup::MeshToQueue,
    placement::{MeshDemand, MeshOutput, Placement},
    queue::Sorter,
    registration::MaterialShaders,
    specialize::{GBufferPipeline, MeshKindKey, kind_key},
};
use crate::view::GBufferTargets;

/// A compiled pipeline for meshes whose own is not ready, with its output.
type StandIn = (MeshOutput, CachedRenderPipelineId);

/// Stand-ins of this frame, by kind of mesh, the output that meshes of that kind should have, and if that is lit.
pub(super) type StandIns = HashMap<(MeshKindKey, MeshOutput, bool), Option<StandIn>>;

impl Sorter<'_, '_, '_, '_, '_, '_> {
    /// A stand-in for the pipeline of a mesh: of those that write a part of what the mesh needs, the one that writes most. `None` if there
    /// is none, or if forward should draw the mesh: because Bevy's pipeline is compiled, or, where Bevy compiles within the frame, because
    /// one frame has not sufficed.
    pub(super) fn stand_in(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        shaders: &MaterialShaders,
        demand: MeshDemand,
        placement: Placement,
    ) -> Option<StandIn> {
        let waits = !placement.is_lit || self.looked_at_again.contains(&entity);
        if waits && !self.pipelines.compile_in_background() {
            return None;
        }
        let kind = kind_key(self.lookup, entity, mesh);
        let wanted = (kind, placement.output, placement.is_lit);
        if let Some(found) = self.stand_ins.get(&wanted) {
            return *found;
        }
        let found = self.find_stand_in(entity, mesh, shaders, demand, placement);
        self.stand_ins.insert(wanted, found);
        found
    }

    fn find_stand_in(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        shaders: &MaterialShaders,
        demand: MeshDemand,
        placement: Placement,
    ) -> Option<StandIn> {
        let active = self.active?;
        let (lookup, view_key) = (self.lookup, self.view_key);
        let of_bevy = self.forward_pipelines.get(lookup, entity, mesh, view_key);
        if of_bevy.is_some_and(|id| matches!(self.pipelines.state(id), GBufferPipeline::Ready(_))) {
            return None;
        }
        let mut written = demand.demand.targets & active.targets;
        // Lighting that does not know of the surface would take the light of a lightmap for emission.
        if !placement.is_lit {
            written -= GBufferTargets::SPECIALIZATION | GBufferTargets::EMISSIVE;
        }
        // Motion is given up before anything that lighting reads.
        let outputs = subsets(written & GBufferTargets::LIT)
            .flat_map(|lit| subsets(written - GBufferTargets::LIT).map(move |others| lit | others));
        outputs
            .map(|targets| {
                let mut less = demand;
                less.demand.targets = targets;
                MeshOutput::of(less, active.targets, active.culls_in_two_phases)
            })
            .find_map(|output| {
                let pipelines = &mut self.pipelines;
                if !pipelines.knows(lookup, entity, mesh, view_key, shaders, output) {
                    return None;
                }
                match pipelines.get(lookup, entity, mesh, view_key, shaders, output) {
                    GBufferPipeline::Ready(id) => Some((output, id)),
                    _ => None,
                }
            })
    }
}

/// All subsets of `targets`, from itself down to none.
fn subsets(targets: GBufferTargets) -> impl Iterator<Item = GBufferTargets> {
    let bits = targets.bits();
    let below = move |subset: &GBufferTargets| {
        let next = subset.bits().checked_sub(1)? & bits;
        Some(GBufferTargets::from_bits_truncate(next))
    };
    core::iter::successors(Some(targets), below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subsets_begin_with_all_and_end_with_none() {
        let targets = GBufferTargets::EMISSIVE | GBufferTargets::MOTION;
        let expected = [
            targets,
            GBufferTargets::MOTION,
            GBufferTargets::EMISSIVE,
            GBufferTargets::empty(),
        ];
        assert_eq!(subsets(targets).collect::<Vec<_>>(), expected);
        let none = GBufferTargets::empty();
        assert_eq!(subsets(none).collect::<Vec<_>>(), [none]);
    }
}
