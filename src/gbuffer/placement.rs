//! Where a mesh goes on a view, and which meshes a change of the view concerns.

use super::demand::MeshDemand;
use crate::view::{ActiveLeanView, Demand, GBufferTargets};

/// Which meshes a change of their view concerns.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum ViewChange {
    None,
    /// Those that need more than the base targets and plain lighting, and alpha-masked ones, where their [`Placement`] is another.
    Demand,
    All,
}

impl ViewChange {
    pub(super) fn between(former: Option<&ActiveLeanView>, now: Option<&ActiveLeanView>) -> Self {
        match (former, now) {
            (None, None) => Self::None,
            (Some(former), Some(now)) => {
                let same_passes = former.draws_in_prepass == now.draws_in_prepass
                    && former.keeps_prepass == now.keeps_prepass
                    && former.extends_all() == now.extends_all()
                    // Where all meshes are in the pass of these targets, more of them concern all.
                    && (!now.extends_all() || former.targets == now.targets);
                if former == now {
                    Self::None
                } else if same_passes {
                    Self::Demand
                } else {
                    Self::All
                }
            }
            _ => Self::All,
        }
    }
}

/// Where a mesh with some demand goes on a view.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Placement {
    /// As far as the view has a use for it.
    pub(super) demand: Demand,
    /// The view has all of it.
    pub(super) is_met: bool,
    /// The optional targets of the pass that it is drawn in.
    pub(super) pass: GBufferTargets,
}

impl Placement {
    /// Alpha-masked meshes hide opaque ones at the same depth, in Bevy's passes too: they are drawn after all of these.
    pub(super) fn of(mesh: MeshDemand, view: &ActiveLeanView) -> Self {
        let demand = mesh.demand.on(view);
        let is_extended = !demand.targets.is_empty() || mesh.is_alpha_masked || view.extends_all();
        Self {
            demand,
            is_met: view.demand().contains(demand),
            pass: if is_extended {
                view.targets
            } else {
                GBufferTargets::empty()
            },
        }
    }

    pub(super) fn is_extended(self) -> bool {
        !self.pass.is_empty()
    }
}
