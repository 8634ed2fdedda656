//! What a view is in this frame.

use bevy::prelude::*;

use super::{
    exchange::LightExchange,
    surfaces::{GBufferTargets, LightingVariants},
};

/// On a view of the render world: this frame it is rendered through the G-buffer.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActiveLeanView {
    /// The view has a depth prepass, so Bevy builds its indirect draws early and wants depth before the main pass:
    /// the G-buffer is drawn in the prepass' place.
    pub draws_in_prepass: bool,
    /// Lean meshes stay in Bevy's prepass, because it writes what only it can write: normals, and then motion vectors
    /// too.
    pub keeps_prepass: bool,
    /// The view has motion vectors, and those of lean meshes are made from the G-buffer.
    pub resolves_motion: bool,
    /// Some light, decal or light probe has layers that keep it from some meshes.
    pub has_light_layers: bool,
    /// The optional targets that the view has.
    pub targets: GBufferTargets,
    /// The kinds of special surfaces that lighting is compiled for.
    pub(crate) variants: LightingVariants,
    /// What lighting takes from other effects, and gives to them.
    pub exchange: LightExchange,
    /// Meshes are drawn twice: those that were visible before, and those that the depth of these does not hide.
    pub culls_in_two_phases: bool,
    /// At the time of lighting, depth other than 0 means that a lean mesh was drawn there: no other known system writes depth before, it starts
    /// at 0, and the projection gives no surface that depth. Then the G-buffer is not cleared, unless depth is found to be drawn into already.
    pub depth_tells_geometry: bool,
}

impl ActiveLeanView {
    /// What meshes may need to be drawn into the G-buffer.
    pub(crate) fn demand(&self) -> Demand {
        Demand {
            targets: self.targets,
            variants: self.variants,
        }
    }

    /// Whether light scatters beneath some of its surfaces.
    pub(crate) fn scatters(&self) -> bool {
        self.exchange.contains(LightExchange::SUBSURFACE_LIGHT) && self.variants.scatter()
    }

    /// Whether meshes that need no optional targets are drawn in the pass that has these all the same: in the second phase
    /// of culling they may come to lie in front of some that do.
    pub(crate) fn extends_all(&self) -> bool {
        self.culls_in_two_phases && !self.targets.is_empty()
    }
}

/// Targets to write and ways to light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Demand {
    pub(crate) targets: GBufferTargets,
    pub(crate) variants: LightingVariants,
}

impl Demand {
    /// Whether all of `other` is in this.
    pub(crate) fn contains(self, other: Self) -> bool {
        self.targets.contains(other.targets) && self.variants.contains(other.variants)
    }

    pub(crate) fn is_empty(self) -> bool {
        self == Self::default()
    }

    /// What is left of it on a view like this one, which may have no use for motion or for layers, or scatter no light.
    pub(crate) fn on(mut self, view: &ActiveLeanView) -> Self {
        if !view.resolves_motion {
            self.targets.remove(GBufferTargets::MOTION);
        }
        if !view.has_light_layers {
            self.targets.remove(GBufferTargets::VISIBILITY_MASK);
        }
        if !view.exchange.contains(LightExchange::SUBSURFACE_LIGHT) {
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
