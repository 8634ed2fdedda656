//! What the shaders are compiled by.

use bevy::shader::ShaderDefVal;

use crate::shader_library::reconstruction::position::ProjectionKind;

/// What all passes are compiled by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct GiKey {
    /// Slices, and steps a side.
    pub(super) samples: (u32, u32),
    pub(super) divisor: u32,
    /// The view has motion vectors.
    pub(super) motion: bool,
    pub(super) projection: ProjectionKind,
}

impl GiKey {
    pub(super) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let (slices, steps) = self.samples;
        let mut defs = vec![
            ShaderDefVal::UInt("SLICES".into(), slices),
            ShaderDefVal::UInt("STEPS".into(), steps),
            ShaderDefVal::UInt("DIVISOR".into(), self.divisor),
        ];
        if self.motion {
            defs.push("MOTION".into());
        }
        defs.extend(self.projection.shader_def().map(ShaderDefVal::from));
        defs
    }

    /// Whether what is bound is the same.
    pub(super) fn binds_like(self, other: Self) -> bool {
        (self.motion, self.projection) == (other.motion, other.projection)
    }
}
