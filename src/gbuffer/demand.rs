//! Tracks the G-buffer targets and lighting variants that the visible meshes of each view need, and derives those that
//! the view gets.
//!
//! A view keeps its targets until the pipelines are compiled that draw its meshes with other ones: no mesh leaves the
//! G-buffer because a target comes or goes. Pipelines are requested for targets that come. Targets that go are kept
//! while that would need new pipelines, until others come.

use core::mem::replace;

use bevy::{
    platform::collections::{HashMap, HashSet},
    prelude::*,
    render::{
        render_resource::{CachedRenderPipelineId, PipelineCache},
        sync_world::{MainEntity, MainEntityHashMap},
        view::RetainedViewEntity,
    },
};

use super::placement::MeshDemand;
use crate::{
    gpu::pipeline_watch::is_settled,
    view::{ActiveLeanView, Demand, GBufferTargets},
};

/// Frames for which a view keeps targets and pipelines that none of its visible meshes needs, so that a mesh which
/// returns to view finds them ready; and frames until targets that could not be released are tried again.
const LINGERING_FRAMES: u32 = 120;

/// Targets that a view should have in place of its own, and what it waits for.
pub(super) struct NextTargets {
    pub(super) targets: GBufferTargets,
    /// Some of them are new. Otherwise some of the present ones are to be released, for which nothing is compiled.
    pub(super) is_growth: bool,
    /// Pipelines of meshes that would leave the G-buffer without them.
    pub(super) awaited: HashSet<CachedRenderPipelineId>,
}

impl NextTargets {
    fn is_ready(&self, cache: &PipelineCache) -> bool {
        let mut awaited = self.awaited.iter();
        awaited.all(|id| is_settled(cache.get_render_pipeline_state(*id)))
    }
}

/// The demand of one view. Each mesh counts with its largest possible demand, including parts that the view has no use
/// for: see [`Demand::on`].
#[derive(Default)]
pub(super) struct ViewDemand {
    by_mesh: MainEntityHashMap<MeshDemand>,
    /// Number of meshes per demand.
    counts: HashMap<Demand, usize>,
    /// Remaining frames for which each current or former demand is met.
    lingering: HashMap<Demand, u32>,
    /// The targets that the view would have a use for, if meshes need them.
    useful: GBufferTargets,
    /// `None` if the view has the targets that it should have.
    pub(super) next: Option<NextTargets>,
    /// Frames for which no target is released.
    kept_for: u32,
}

impl ViewDemand {
    /// Meshes that need more than the base targets and plain lighting, and alpha-masked meshes.
    pub(super) fn each(&self) -> impl Iterator<Item = (MainEntity, MeshDemand)> {
        self.by_mesh.iter().map(|(mesh, demand)| (*mesh, *demand))
    }

    /// Records the needs of `mesh` in place of its former ones.
    pub(super) fn insert(&mut self, mesh: MainEntity, demand: MeshDemand) {
        if self.by_mesh.get(&mesh) == Some(&demand) {
            return;
        }
        self.remove(mesh);
        if !demand.is_plain() {
            self.by_mesh.insert(mesh, demand);
            *self.counts.entry(demand.demand).or_default() += 1;
        }
    }

    pub(super) fn remove(&mut self, mesh: MainEntity) {
        if self.by_mesh.is_empty() {
            return;
        }
        let Some(MeshDemand { demand, .. }) = self.by_mesh.remove(&mesh) else {
            return;
        };
        if let Some(count) = self.counts.get_mut(&demand) {
            *count -= 1;
            if *count == 0 {
                self.counts.remove(&demand);
            }
        }
    }

    /// Forgets all meshes, as for a camera that is switched off. Their demands linger like those of meshes out of
    /// sight.
    fn forget_meshes(&mut self) {
        self.by_mesh.clear();
        for (demand, _) in self.counts.drain() {
            self.lingering.insert(demand, LINGERING_FRAMES);
        }
        self.next = None;
    }

    /// Returns the current demand with and without lingering ones. Call once per frame.
    fn wanted(&mut self) -> [Demand; 2] {
        self.kept_for = self.kept_for.saturating_sub(1);
        self.lingering.retain(|_, frames| {
            *frames = frames.saturating_sub(1);
            *frames > 0
        });
        for demand in self.counts.keys() {
            self.lingering.insert(*demand, LINGERING_FRAMES);
        }
        [union(self.lingering.keys()), union(self.counts.keys())]
    }

    /// The targets that a view with those of `view` should have instead: more if its meshes need more, or else fewer if
    /// none has needed some of them for a while. Each set has pipelines of its own: a view that gets targets releases
    /// others with them, and a set for which pipelines are compiled is kept while it has all that is needed.
    pub(super) fn next_targets(&self, view: &ActiveLeanView) -> Option<GBufferTargets> {
        let useful = self.useful | view.useful_targets();
        let needed = union(self.counts.keys()).targets & useful;
        let recent = union(self.lingering.keys()).targets & useful;
        let least = (view.targets & recent) | needed;
        if view.targets.contains(needed) {
            return (least != view.targets && self.kept_for == 0).then_some(least);
        }
        let prepared = self.next.as_ref().map(|next| next.targets);
        let most = view.targets | needed;
        let fits = |targets: &GBufferTargets| targets.contains(least) && most.contains(*targets);
        prepared.filter(fits).or(Some(least))
    }

    /// Keeps the present targets for a while, because meshes have no pipelines for fewer.
    pub(super) fn keep_targets(&mut self) {
        self.next = None;
        self.kept_for = LINGERING_FRAMES;
    }

    /// Targets of a view that was in the state `last` in the last frame. It begins to resolve motion and to test light
    /// layers once it has the target for it, if a mesh needs that: until then, `order` is changed.
    fn targets(
        &mut self,
        order: &mut ActiveLeanView,
        last: &ActiveLeanView,
        meshes_move: bool,
        cache: &PipelineCache,
    ) -> GBufferTargets {
        let useful = order.useful_targets();
        let newly_useful = useful - replace(&mut self.useful, useful);
        let next = self.next_targets(last);
        let ready = self.next.as_ref().filter(|ready| ready.is_ready(cache));
        let targets = match (next, ready) {
            (Some(next), Some(ready)) if next == ready.targets => next,
            _ => last.targets,
        };
        let mut lacking = union(self.counts.keys()).targets;
        // Meshes that move are sorted later in the frame.
        if meshes_move {
            lacking |= newly_useful & GBufferTargets::MOTION;
        }
        lacking -= targets;
        if lacking.contains(GBufferTargets::MOTION)
            && order.resolves_motion
            && !last.resolves_motion
        {
            order.resolves_motion = false;
            order.keeps_prepass = true;
        }
        if lacking.contains(GBufferTargets::VISIBILITY_MASK) {
            order.has_light_layers &= last.has_light_layers;
        }
        targets
    }
}

fn union<'a>(demands: impl Iterator<Item = &'a Demand>) -> Demand {
    demands.fold(Demand::default(), |all, demand| all.union(*demand))
}

/// The demands of all lean views.
#[derive(Resource, Default)]
pub(crate) struct ViewDemands(HashMap<RetainedViewEntity, ViewDemand>);

impl ViewDemands {
    pub(super) fn of(&mut self, view: RetainedViewEntity) -> &mut ViewDemand {
        self.0.entry(view).or_default()
    }

    /// Forgets the meshes of views that are not `active`, and drops views that no longer `exist`. The first frame after
    /// a pause then has targets and lighting for the content of the last frame before it.
    pub(super) fn retain(
        &mut self,
        active: impl Fn(&RetainedViewEntity) -> bool,
        exist: impl Fn(&RetainedViewEntity) -> bool,
    ) {
        self.0.retain(|view, demand| {
            let is_active = active(view);
            if !is_active {
                demand.forget_meshes();
            }
            is_active || exist(view)
        });
    }

    /// Demand of the meshes of all views, including lingering ones.
    fn of_all(&self) -> Demand {
        union(self.0.values().flat_map(|view| view.lingering.keys()))
    }

    /// True if visible meshes of `view` scatter light beneath their surfaces, now or within the lingering time. A view
    /// in its first frame is assumed to if any other does.
    pub(crate) fn scatter(&self, view: RetainedViewEntity) -> bool {
        match self.0.get(&view) {
            Some(demand) => (demand.lingering.keys()).any(|demand| demand.variants.scatter()),
            None => self.of_all().variants.scatter(),
        }
    }

    /// Demand that `view`, drawn in this `order`, should meet in this frame, from the needs of its meshes up to the last
    /// one: with and without lingering ones. `last` is its state in the last frame; without one it has no mesh in the
    /// G-buffer that could leave it. For a view in its first frame the best guess is the demand of all other views.
    /// `order` is changed for a view that lacks targets for it.
    pub(crate) fn wanted(
        &mut self,
        view: RetainedViewEntity,
        order: &mut ActiveLeanView,
        last: Option<&ActiveLeanView>,
        meshes_move: bool,
        cache: &PipelineCache,
    ) -> [Demand; 2] {
        let Some(demand) = self.0.get_mut(&view) else {
            let targets = order.useful_targets();
            return [self.of_all(), Demand::default()].map(|demand| Demand {
                targets: demand.targets & targets,
                ..demand
            });
        };
        let demands = demand.wanted();
        match last {
            Some(last) => {
                let targets = demand.targets(order, last, meshes_move, cache);
                demands.map(|demand| Demand { targets, ..demand })
            }
            None => {
                demand.useful = order.useful_targets();
                demands.map(|wanted| Demand {
                    targets: wanted.targets & demand.useful,
                    ..wanted
                })
            }
        }
    }
}
