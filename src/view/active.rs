//! The state of a view in this frame.

use bevy::prelude::*;

use super::{
    lighting_io::LightingIo,
    surfaces::{GBufferTargets, LightingVariants},
};

/// On a view of the render world: it is rendered through the G-buffer in this frame.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActiveLeanView {
    /// The view has a depth prepass, so Bevy builds its indirect draws early and needs depth before the main pass. The
    /// G-buffer is drawn in place of the prepass.
    pub draws_in_prepass: bool,
    /// Lean meshes stay in Bevy's prepass for outputs that only it can write: normals, and with these motion vectors.
    pub keeps_prepass: bool,
    /// The view has motion vectors, and those of lean meshes are resolved from the G-buffer.
    pub resolves_motion: bool,
    /// Some light, decal or light probe has layers that exclude some meshes.
    pub has_light_layers: bool,
    /// The optional targets that the view has. Meshes write those that they need, even if the view has no use for them.
    pub targets: GBufferTargets,
    /// The kinds of surfaces that lighting lights beside plain ones.
    pub(crate) variants: LightingVariants,
    /// The light that lighting exchanges with other effects.
    pub io: LightingIo,
    /// Meshes are drawn in two phases: those that were visible before, then those that the resulting depth does not
    /// occlude.
    pub culls_in_two_phases: bool,
    /// When lighting runs, depth other than 0 means that a lean mesh was drawn at the pixel: no other known system
    /// writes depth before, depth is cleared to 0, and the projection gives no surface that depth. The G-buffer is then
    /// not cleared, unless depth turns out to be drawn into already.
    pub depth_tells_geometry: bool,
}

impl ActiveLeanView {
    /// The optional targets that the view has a use for.
    pub(crate) fn useful_targets(&self) -> GBufferTargets {
        let mut targets = GBufferTargets::all();
        targets.set(GBufferTargets::MOTION, self.resolves_motion);
        targets.set(GBufferTargets::VISIBILITY_MASK, self.has_light_layers);
        targets
    }

    /// The demand of meshes that the view meets.
    pub(crate) fn demand(&self) -> Demand {
        Demand {
            targets: self.targets,
            variants: self.variants,
        }
    }

    /// True if light scatters beneath some of its surfaces.
    pub(crate) fn scatters(&self) -> bool {
        self.io.contains(LightingIo::SUBSURFACE_LIGHT) && self.variants.scatter()
    }

    /// True if meshes without optional targets clear the valid mask: in the second phase of culling they may lie in
    /// front of meshes that have some.
    pub(crate) fn all_clear_valid_mask(&self) -> bool {
        self.culls_in_two_phases && !self.targets.is_empty()
    }
}

/// A set of optional targets and lighting variants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Demand {
    pub(crate) targets: GBufferTargets,
    pub(crate) variants: LightingVariants,
}

impl Demand {
    /// True if this includes all of `other`.
    pub(crate) fn contains(self, other: Self) -> bool {
        self.targets.contains(other.targets) && self.variants.contains(other.variants)
    }

    pub(crate) fn is_empty(self) -> bool {
        self == Self::default()
    }

    /// Removes parts that `view` has no use for: motion, layers or scattering.
    pub(crate) fn on(mut self, view: &ActiveLeanView) -> Self {
        self.targets &= view.useful_targets();
        if !view.io.contains(LightingIo::SUBSURFACE_LIGHT) {
            self.variants = self.variants.unscattered();
        }
        self
    }

    pub(crate) fn union(self, other: Self) -> Self {
        Self {
            targets: self.targets | other.targets,
            variants: self.variants | other.variants,
        }
    }
}
