//! Pipeline key.

use bevy::shader::ShaderDefVal;

use crate::shader_library::reconstruction::position::ProjectionKind;

/// Pipeline key of all passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct GiKey {
    /// Slices, and steps per side.
    pub(super) samples: (u32, u32),
    pub(super) divisor: u32,
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
        defs.extend(self.projection.shader_def().map(ShaderDefVal::from));
        defs
    }

    /// True if its pipelines can stand in for those of `other` until they are compiled.
    pub(super) fn stands_in_for(self, other: Self) -> bool {
        self.projection.covers(other.projection)
    }
}
