//! What the shaders are compiled by.

use bevy::shader::ShaderDefVal;

use super::settings::ScreenSpaceReflectionsQuality;
use crate::shader_library::reconstruction::position::ProjectionKind;

/// What all passes are compiled by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ReflectionKey {
    pub(super) quality: ScreenSpaceReflectionsQuality,
    pub(super) divisor: u32,
    /// The view has motion vectors.
    pub(super) motion: bool,
    /// The view may have special surfaces.
    pub(super) specialization: bool,
    pub(super) projection: ProjectionKind,
}

impl ReflectionKey {
    pub(super) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let pixels = self.resolve_side();
        // Texels a side whose mean a workgroup of the last pass makes, and that it reads.
        let means = pixels / self.divisor + self.divisor - 1;
        let side = means + 3;
        let mut defs = vec![
            ShaderDefVal::UInt("ROUGH_SEGMENTS".into(), self.quality.rough_segments()),
            ShaderDefVal::UInt("SHORTEST_SEGMENT".into(), self.quality.shortest_segment()),
            ShaderDefVal::UInt("GROWTH_PERCENT".into(), self.quality.growth_percent()),
            ShaderDefVal::UInt("SMOOTH_STEPS".into(), self.quality.smooth_steps()),
            ShaderDefVal::UInt("ROUGH_RAYS".into(), self.quality.rough_rays()),
            ShaderDefVal::UInt("DIVISOR".into(), self.divisor),
            ShaderDefVal::UInt("PIXELS".into(), pixels),
            ShaderDefVal::UInt("SIDE_SQUARED".into(), side * side),
            ShaderDefVal::UInt("MEANS_SQUARED".into(), means * means),
        ];
        if self.motion {
            defs.push("MOTION".into());
        }
        if self.specialization {
            defs.push("SPECIALIZATION".into());
        }
        defs.extend(self.projection.shader_def().map(ShaderDefVal::from));
        defs
    }

    /// Pixels a side that a workgroup of the last pass makes: of large ones fewer texels are read twice, and what they read has to fit
    /// into 16 KiB.
    pub(super) fn resolve_side(self) -> u32 {
        if self.divisor == 1 { 16 } else { 32 }
    }

    /// Whether what is bound is the same.
    pub(super) fn binds_like(self, other: Self) -> bool {
        (self.motion, self.projection) == (other.motion, other.projection)
    }
}
