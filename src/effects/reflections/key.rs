//! Pipeline key.

use bevy::shader::ShaderDefVal;

use crate::{
    gpu::effect_pipelines::EffectKey, shader_library::reconstruction::position::ProjectionKind,
};

/// Pipeline key of all passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ReflectionKey {
    /// Pixels per side of a texel. Sizes of shared memory depend on it.
    pub(super) divisor: u32,
    pub(super) projection: ProjectionKind,
}

impl EffectKey for ReflectionKey {
    fn shader_defs(self) -> Vec<ShaderDefVal> {
        let mut defs = vec![ShaderDefVal::UInt("DIVISOR".into(), self.divisor)];
        defs.extend(self.projection.shader_def().map(ShaderDefVal::from));
        defs
    }

    fn stands_in_for(self, wanted: Self) -> bool {
        self.projection.covers(wanted.projection)
    }
}
