//! Draws a mesh by a pipeline that writes less than the mesh needs, until the right one and its targets are ready.
//!
//! A mesh that begins to emit light or to move is left to Bevy until its new pipeline is compiled, if Bevy's is. Otherwise it would
//! vanish.

use bevy::render::{render_resource::CachedRenderPipelineId, sync_world::MainEntity};

use super::{
    lookup::MeshToQueue,
    placement::{MeshDemand, MeshOutput, Placement},
    queue::Sorter,
    registration::MaterialShaders,
    specialize::GBufferPipeline,
};
use crate::view::GBufferTargets;

impl Sorter<'_, '_, '_, '_, '_, '_> {
    /// A compiled pipeline for a mesh whose own is not ready, with its output: of those that write a part of what the mesh needs, the one
    /// that writes most. `None` if there is none, or if Bevy's pipeline is compiled: forward then draws the mesh with all that it shows.
    pub(super) fn stand_in(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        shaders: &MaterialShaders,
        demand: MeshDemand,
        placement: Placement,
    ) -> Option<(MeshOutput, CachedRenderPipelineId)> {
        let active = self.active?;
        let (lookup, view_key) = (self.lookup, self.view_key);
        let of_bevy = self.forward_pipelines.get(lookup, entity, mesh, view_key);
        if of_bevy.is_some_and(|id| matches!(self.pipelines.state(id), GBufferPipeline::Ready(_))) {
            return None;
        }
        let mut written = demand.demand.targets & active.targets;
        // Baked light is no emission.
        if !placement.is_lit {
            written -= GBufferTargets::SPECIALIZATION | GBufferTargets::EMISSIVE;
        }
        // What lighting reads is seen sooner than motion.
        let outputs = subsets(written & GBufferTargets::LIT)
            .flat_map(|lit| subsets(written - GBufferTargets::LIT).map(move |others| lit | others));
        outputs
            .map(|targets| {
                let mut less = demand;
                less.demand.targets = targets;
                MeshOutput::of(less, active.targets, active.culls_in_two_phases)
            })
            .find_map(|output| {
                let is_known =
                    (self.pipelines).knows(lookup, entity, mesh, view_key, shaders, output);
                let pipeline = is_known
                    .then(|| (self.pipelines).get(lookup, entity, mesh, view_key, shaders, output));
                match pipeline {
                    Some(GBufferPipeline::Ready(id)) => Some((output, id)),
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
