//! Pipeline key.

use bevy::shader::ShaderDefVal;

use crate::{
    gpu::effect_pipelines::EffectKey, shader_library::reconstruction::position::ProjectionKind,
};

/// Pipeline key of all passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct GiKey {
    /// Slices, and steps per side. Compiled in, so that loops unroll.
    pub(super) samples: (u32, u32),
    pub(super) projection: ProjectionKind,
}

impl EffectKey for GiKey {
    fn shader_defs(self) -> Vec<ShaderDefVal> {
        let (slices, steps) = self.samples;
        let mut defs = vec![
            ShaderDefVal::UInt("SLICES".into(), slices),
            ShaderDefVal::UInt("STEPS".into(), steps),
        ];
        defs.extend(self.projection.shader_def().map(ShaderDefVal::from));
        defs
    }

    fn stands_in_for(self, wanted: Self) -> bool {
        self.projection.covers(wanted.projection)
    }
}
