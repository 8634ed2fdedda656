//! Places meshes in the passes of a view, and tells which meshes a change of the view concerns.

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
                    && former.all_clear_valid_mask() == now.all_clear_valid_mask();
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

/// Needs of a mesh, with the other property that decides its placement.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct MeshDemand {
    pub(super) demand: Demand,
    pub(super) is_alpha_masked: bool,
}

impl MeshDemand {
    /// True if no possible change of a view's demand concerns the mesh.
    pub(super) fn is_plain(self) -> bool {
        self.demand.is_empty() && !self.is_alpha_masked
    }
}

/// The pass of a mesh, and the optional targets that it writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct MeshOutput {
    /// The optional targets of the pass.
    pub(super) pass: GBufferTargets,
    /// The pass has the `valid_mask` target.
    pub(super) has_valid_mask: bool,
    /// The targets of the pass that the mesh writes.
    pub(super) targets: GBufferTargets,
}

impl MeshOutput {
    /// Output of a mesh on a view with the optional targets `available`. The mesh writes those of its demand. If there
    /// are none, its pipeline does not depend on the targets of the view. It clears the valid mask where it may be drawn
    /// over meshes with optional targets: if it is alpha-masked, and with culling `in_two_phases`.
    pub(super) fn of(mesh: MeshDemand, available: GBufferTargets, in_two_phases: bool) -> Self {
        let targets = mesh.demand.targets & available;
        let is_extended = !targets.is_empty();
        Self {
            pass: if is_extended {
                available
            } else {
                GBufferTargets::empty()
            },
            has_valid_mask: is_extended
                || (!available.is_empty() && (mesh.is_alpha_masked || in_two_phases)),
            targets,
        }
    }

    /// True if the mesh is drawn in the pass with optional targets.
    pub(super) fn is_extended(self) -> bool {
        !self.pass.is_empty()
    }
}

/// Placement of a mesh on a view.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Placement {
    /// True if the view has the targets that the mesh needs.
    pub(super) has_targets: bool,
    /// True if lighting is compiled for its kind of surface.
    pub(super) is_lit: bool,
    pub(super) output: MeshOutput,
}

impl Placement {
    pub(super) fn of(mesh: MeshDemand, view: &ActiveLeanView) -> Self {
        let demand = mesh.demand.on(view);
        Self {
            has_targets: view.targets.contains(demand.targets),
            is_lit: view.variants.contains(demand.variants),
            output: MeshOutput::of(mesh, view.targets, view.culls_in_two_phases),
        }
    }

    /// True if the mesh can be drawn once its pipeline is compiled.
    pub(super) fn is_met(self) -> bool {
        self.has_targets && self.is_lit
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::view::LightingVariants;

    /// Each output is a pipeline. A mesh is drawn with those of its material, in motion or not, with layers or not, on views with any
    /// targets.
    #[test]
    fn meshes_of_a_material_have_few_outputs() {
        let all_sets = || (0..16).map(GBufferTargets::from_bits_truncate);
        let of_instances = GBufferTargets::MOTION | GBufferTargets::VISIBILITY_MASK;
        let of_material = [
            (GBufferTargets::empty(), 22),
            (GBufferTargets::EMISSIVE, 30),
            (GBufferTargets::SPECIALIZATION, 30),
            (
                GBufferTargets::EMISSIVE | GBufferTargets::SPECIALIZATION,
                34,
            ),
        ];
        for (own, expected) in of_material {
            for is_alpha_masked in [false, true] {
                let mut outputs = HashSet::new();
                for of_instance in all_sets().filter(|set| of_instances.contains(*set)) {
                    let demand = Demand {
                        targets: own | of_instance,
                        variants: LightingVariants::empty(),
                    };
                    let mesh = MeshDemand {
                        demand,
                        is_alpha_masked,
                    };
                    for available in all_sets() {
                        for in_two_phases in [false, true] {
                            outputs.insert(MeshOutput::of(mesh, available, in_two_phases));
                        }
                    }
                }
                assert_eq!(outputs.len(), expected, "{own:?}");
            }
        }
    }
}
