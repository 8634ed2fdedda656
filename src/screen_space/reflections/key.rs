//! Pipeline key.

use bevy::shader::ShaderDefVal;

use super::settings::ScreenSpaceReflectionsQuality;
use crate::shader_library::reconstruction::position::ProjectionKind;

/// Pipeline key of all passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ReflectionKey {
    pub(super) quality: ScreenSpaceReflectionsQuality,
    /// Pixels per side of a texel.
    pub(super) divisor: u32,
    /// Shortest segment of a ray, in pixels.
    pub(super) shortest_segment: u32,
    /// The view may have special surfaces.
    pub(super) specialization: bool,
    pub(super) projection: ProjectionKind,
    /// The debug view shows hits, which are then written for texels without a ray too.
    pub(super) shown: bool,
}

impl ReflectionKey {
    pub(super) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let mut defs = vec![
            ShaderDefVal::UInt("ROUGH_SEGMENTS".into(), self.quality.rough_segments()),
            ShaderDefVal::UInt("SHORTEST_SEGMENT".into(), self.shortest_segment),
            ShaderDefVal::UInt("GROWTH_PERCENT".into(), self.quality.growth_percent()),
            ShaderDefVal::UInt("SMOOTH_STEPS".into(), self.quality.smooth_steps()),
            ShaderDefVal::UInt("DIVISOR".into(), self.divisor),
        ];
        if self.specialization {
            defs.push("SPECIALIZATION".into());
        }
        if self.shown {
            defs.push("SHOWN".into());
        }
        defs.extend(self.projection.shader_def().map(ShaderDefVal::from));
        defs
    }

    /// True if its pipelines can stand in for those of `other` until they are compiled.
    pub(super) fn stands_in_for(self, other: Self) -> bool {
        self.projection.covers(other.projection)
    }
}
