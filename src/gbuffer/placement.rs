//! Places meshes in the passes of a view, and tells which meshes a change of the view concerns.

use super::demand::MeshDemand;
use crate::view::{ActiveLeanView, Demand, GBufferTargets};

/// The meshes that a change of their view concerns.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum ViewChange {
    None,
    /// Meshes that need more than the base targets and plain lighting, and alpha-masked ones, if their [`Placement`]
    /// changes.
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
                    // If the extended pass has all meshes, a change of its targets concerns all.
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

/// Placement of a mesh on a view.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Placement {
    /// Its demand, reduced to what the view has a use for.
    pub(super) demand: Demand,
    /// True if the view meets this demand.
    pub(super) is_met: bool,
    /// The optional targets of the pass that it is drawn in.
    pub(super) pass: GBufferTargets,
}

impl Placement {
    /// Puts alpha-masked meshes into the extended pass: they hide opaque ones at equal depth, as in Bevy's passes, so
    /// they are drawn after all of these.
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
}
