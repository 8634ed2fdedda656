//! Tracks the G-buffer targets and lighting variants that the visible meshes of each view need, and derives those that
//! the view gets.

use bevy::{
    platform::collections::HashMap,
    prelude::*,
    render::{
        sync_world::{MainEntity, MainEntityHashMap},
        view::RetainedViewEntity,
    },
};

use super::placement::MeshDemand;
use crate::view::Demand;

/// Frames for which a view keeps targets and pipelines that none of its visible meshes needs, so that a mesh which
/// returns to view finds them ready.
const LINGERING_FRAMES: u32 = 120;

/// The demand of one view. Each mesh counts with its largest possible demand, including parts that the view has no use
/// for: see [`Demand::on`].
#[derive(Default)]
pub(super) struct ViewDemand {
    by_mesh: MainEntityHashMap<MeshDemand>,
    /// Number of meshes per demand.
    counts: HashMap<Demand, usize>,
    /// Remaining frames for which each current or former demand is met.
    lingering: HashMap<Demand, u32>,
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
    }

    /// Returns the current demand with and without lingering ones. Call once per frame.
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
        let demands = self.0.values().flat_map(|view| view.lingering.keys());
        demands.fold(Demand::default(), |all, demand| all.union(*demand))
    }

    /// True if visible meshes of `view` scatter light beneath their surfaces, now or within the lingering time. A view
    /// in its first frame is assumed to if any other does.
    pub(crate) fn scatter(&self, view: RetainedViewEntity) -> bool {
        match self.0.get(&view) {
            Some(demand) => (demand.lingering.keys()).any(|demand| demand.variants.scatter()),
            None => self.of_all().variants.scatter(),
        }
    }

    /// Demand that `view` should meet in this frame, from the needs of its meshes up to the last one: with and without
    /// lingering ones. For a view in its first frame the best guess is the demand of all other views.
    pub(crate) fn wanted(&mut self, view: RetainedViewEntity) -> [Demand; 2] {
        match self.0.get_mut(&view) {
            Some(demand) => demand.wanted(),
            None => [self.of_all(), Demand::default()],
        }
    }
}
