//! What the visible meshes of each view need of the G-buffer and of lighting, and what a view gets for it.

use bevy::{
    platform::collections::HashMap,
    prelude::*,
    render::{
        sync_world::{MainEntity, MainEntityHashMap},
        view::RetainedViewEntity,
    },
};

use crate::view::Demand;

/// Frames that a view keeps what none of its visible meshes needs any more: what goes out of sight and comes back
/// finds textures and pipelines as they were.
const LINGERING_FRAMES: u32 = 120;

/// What a mesh needs, and what else says where it goes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct MeshDemand {
    pub(super) demand: Demand,
    pub(super) is_alpha_masked: bool,
}

impl MeshDemand {
    /// Nothing that a view may come to have concerns the mesh.
    fn is_plain(self) -> bool {
        self.demand.is_empty() && !self.is_alpha_masked
    }
}

/// The demand of one view. Of each mesh it is the largest that there can be, whether the view has a use for all of it
/// or not: see [`Demand::on`].
#[derive(Default)]
pub(super) struct ViewDemand {
    by_mesh: MainEntityHashMap<MeshDemand>,
    /// How many meshes have each demand.
    counts: HashMap<Demand, usize>,
    /// For how many more frames each demand of before is met.
    lingering: HashMap<Demand, u32>,
}

impl ViewDemand {
    /// The meshes that need more than the base targets and plain lighting, and those that are alpha-masked.
    pub(super) fn each(&self) -> impl Iterator<Item = (MainEntity, MeshDemand)> {
        self.by_mesh.iter().map(|(mesh, demand)| (*mesh, *demand))
    }

    /// Records what `mesh` needs, in place of what it needed before.
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

    /// Forgets a mesh.
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

    /// Forgets all meshes, as those of a camera that is switched off. What they need is kept in mind as long as that of meshes out of sight.
    fn forget_meshes(&mut self) {
        self.by_mesh.clear();
        for (demand, _) in self.counts.drain() {
            self.lingering.insert(demand, LINGERING_FRAMES);
        }
    }

    /// What is needed now and what was a little while ago, and what is needed now. To be called once a frame.
    fn wanted(&mut self) -> [Demand; 2] {
        self.lingering.retain(|_, frames| {
            *frames = frames.saturating_sub(1);
            *frames > 0
        });
        for demand in self.counts.keys() {
            self.lingering.insert(*demand, LINGERING_FRAMES);
        }
        let all = |demands: &mut dyn Iterator<Item = &Demand>| {
            demands.fold(Demand::default(), |all, demand| all.union(*demand))
        };
        [
            all(&mut self.lingering.keys()),
            all(&mut self.counts.keys()),
        ]
    }
}

/// The demands of all lean views.
#[derive(Resource, Default)]
pub(crate) struct ViewDemands(HashMap<RetainedViewEntity, ViewDemand>);

impl ViewDemands {
    pub(super) fn of(&mut self, view: RetainedViewEntity) -> &mut ViewDemand {
        self.0.entry(view).or_default()
    }

    /// Forgets the meshes of views that are not `active`, and those that `exist` no more. The first frame after a pause then has targets and
    /// lighting for what the last one before it showed.
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

    /// Needs of the meshes of all views, of this frame or a little while ago.
    fn of_all(&self) -> Demand {
        let demands = self.0.values().flat_map(|view| view.lingering.keys());
        demands.fold(Demand::default(), |all, demand| all.union(*demand))
    }

    /// True if `view` has, or had a little while ago, visible meshes beneath whose surfaces light scatters. A view in its first frame may
    /// have some if others do.
    pub(crate) fn scatter(&self, view: RetainedViewEntity) -> bool {
        match self.0.get(&view) {
            Some(demand) => (demand.lingering.keys()).any(|demand| demand.variants.scatter()),
            None => self.of_all().variants.scatter(),
        }
    }

    /// What `view` should have in this frame, by what its meshes needed up to the last one: with what they needed a little
    /// while ago, and without. A view in its first frame shows, for all that is known, what others do.
    pub(crate) fn wanted(&mut self, view: RetainedViewEntity) -> [Demand; 2] {
        match self.0.get_mut(&view) {
            Some(demand) => demand.wanted(),
            None => [self.of_all(), Demand::default()],
        }
    }
}
