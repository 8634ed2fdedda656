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
    fn count_frame(&mut self) -> [Demand; 2] {
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

    /// Demand of the meshes that need no other targets than those of `view`, with and without lingering ones.
    fn met_by(&self, view: &ActiveLeanView) -> [Demand; 2] {
        let useful = view.useful_targets();
        let is_met = |demand: &&Demand| view.targets.contains(demand.targets & useful);
        let demands = [
            union(self.lingering.keys().filter(is_met)),
            union(self.counts.keys().filter(is_met)),
        ];
        demands.map(|demand| Demand {
            targets: view.targets,
            ..demand
        })
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

    /// See [`ViewDemands::wanted`].
    fn wanted(
        &mut self,
        order: ActiveLeanView,
        last: Option<&ActiveLeanView>,
        meshes_move: bool,
        cache: &PipelineCache,
    ) -> WantedDemand {
        let useful = order.useful_targets();
        let newly_useful = useful - replace(&mut self.useful, useful);
        let demands = self.count_frame();
        let Some(last) = last else {
            return WantedDemand::at_first(demands, order, None);
        };
        let next = self.next_targets(last);
        let prepared = (self.next.as_ref()).filter(|prepared| Some(prepared.targets) == next);
        let (targets, next) = match prepared {
            Some(prepared) if prepared.is_ready(cache) => (prepared.targets, None),
            Some(prepared) if prepared.is_growth => (last.targets, Some(prepared.targets)),
            _ => (last.targets, None),
        };
        let [_, current] = demands;
        let mut needed = current.targets;
        // Meshes that move are sorted later in the frame.
        if meshes_move {
            needed |= newly_useful & GBufferTargets::MOTION;
        }
        let mut wanted = WantedDemand {
            demands,
            next: None,
            needed,
            last: Some(*last),
        };
        let with = |targets| wanted.view(order, targets);
        let demands = self.met_by(&with(targets));
        wanted.next = next.map(|targets| self.met_by(&with(targets))[0]);
        wanted.demands = demands;
        wanted
    }
}

/// The demand that a view should meet in a frame.
#[derive(Clone, Copy)]
pub(crate) struct WantedDemand {
    /// The demand with and without lingering ones. It lacks that of meshes for whose targets the view still waits.
    pub(crate) demands: [Demand; 2],
    /// The demand with the targets for which the view waits, if any.
    pub(crate) next: Option<Demand>,
    /// The targets that meshes need, whatever use the view has for them.
    needed: GBufferTargets,
    /// State of the view in the last frame.
    pub(crate) last: Option<ActiveLeanView>,
}

impl WantedDemand {
    /// Demand of a view without a mesh in the G-buffer that could leave it.
    fn at_first(
        demands: [Demand; 2],
        order: ActiveLeanView,
        last: Option<&ActiveLeanView>,
    ) -> Self {
        Self {
            demands: demands.map(|demand| Demand {
                targets: demand.targets & order.useful_targets(),
                ..demand
            }),
            next: None,
            needed: GBufferTargets::empty(),
            last: last.copied(),
        }
    }

    /// The view with these `targets`, drawn in this `order`. It begins to resolve motion and to test light layers once it
    /// has the target for it, if a mesh needs that.
    pub(crate) fn view(&self, order: ActiveLeanView, targets: GBufferTargets) -> ActiveLeanView {
        let mut view = ActiveLeanView { targets, ..order };
        let Some(last) = self.last else {
            return view;
        };
        let lacking = self.needed - targets;
        if lacking.contains(GBufferTargets::MOTION) && view.resolves_motion && !last.resolves_motion
        {
            view.resolves_motion = false;
            view.keeps_prepass = true;
        }
        if lacking.contains(GBufferTargets::VISIBILITY_MASK) {
            view.has_light_layers &= last.has_light_layers;
        }
        view
    }
}

fn union<'a>(demands: impl Iterator<Item = &'a Demand>) -> Demand {
    demands.fold(Demand::default(), |all, demand| all.union(*demand))
}

/// The demands of all lean views.
#[derive(Resource, Default)]
pub(crate) struct ViewDemands {
    views: HashMap<RetainedViewEntity, ViewDemand>,
    /// Demand of the last views that were dropped.
    of_dropped: Demand,
}

impl ViewDemands {
    pub(super) fn of(&mut self, view: RetainedViewEntity) -> &mut ViewDemand {
        self.views.entry(view).or_default()
    }

    /// Forgets the meshes of views that are not `active`, and drops views that no longer `exist`. The first frame after
    /// a pause then has targets and lighting for the content of the last frame before it.
    pub(super) fn retain(
        &mut self,
        active: impl Fn(&RetainedViewEntity) -> bool,
        exist: impl Fn(&RetainedViewEntity) -> bool,
    ) {
        let mut of_dropped = Demand::default();
        self.views.retain(|view, demand| {
            if active(view) {
                return true;
            }
            demand.forget_meshes();
            let is_kept = exist(view);
            if !is_kept {
                of_dropped = of_dropped.union(union(demand.lingering.keys()));
            }
            is_kept
        });
        // A camera of a menu may have had no meshes.
        if !of_dropped.is_empty() {
            self.of_dropped = of_dropped;
        }
    }

    /// Demand of the meshes of all views, including lingering ones; if there are none, that of the last ones there were: a camera may be
    /// spawned anew for each level or picture.
    fn of_all(&self) -> Demand {
        if self.views.is_empty() {
            return self.of_dropped;
        }
        union(self.views.values().flat_map(|view| view.lingering.keys()))
    }

    /// True if visible meshes of `view` scatter light beneath their surfaces, now or within the lingering time. A view
    /// in its first frame is assumed to if any other does, or did.
    pub(crate) fn scatter(&self, view: RetainedViewEntity) -> bool {
        match self.views.get(&view) {
            Some(demand) => (demand.lingering.keys()).any(|demand| demand.variants.scatter()),
            None => self.of_all().variants.scatter(),
        }
    }

    /// Demand that `view`, drawn in this `order`, should meet in this frame, from the needs of its meshes up to the last
    /// one. `last` is its state in the last frame. For a view in its first frame the best guess is the demand of all other
    /// views, or of the last ones there were.
    pub(crate) fn wanted(
        &mut self,
        view: RetainedViewEntity,
        order: ActiveLeanView,
        last: Option<&ActiveLeanView>,
        meshes_move: bool,
        cache: &PipelineCache,
    ) -> WantedDemand {
        match self.views.get_mut(&view) {
            Some(demand) => demand.wanted(order, last, meshes_move, cache),
            None => WantedDemand::at_first([self.of_all(), Demand::default()], order, last),
        }
    }
}
