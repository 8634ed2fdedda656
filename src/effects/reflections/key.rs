//! Pipeline key.

use bevy::shader::ShaderDefVal;

use super::settings::Marches;
use crate::{
    gpu::{effect_pipelines::EffectKey, shader_defs},
    shader_library::reconstruction::position::ProjectionKind,
};

/// Pipeline key of all passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ReflectionKey {
    pub(super) marches: Marches,
    /// Pixels per side of a texel.
    pub(super) divisor: u32,
    /// The view may have special surfaces.
    pub(super) specialization: bool,
    pub(super) projection: ProjectionKind,
    /// The debug view shows hits, which are then written for texels without a ray too.
    pub(super) shown: bool,
}

impl EffectKey for ReflectionKey {
    fn shader_defs(self) -> Vec<ShaderDefVal> {
        let marches = self.marches;
        let mut defs = vec![
            ShaderDefVal::UInt("ROUGH_SEGMENTS".into(), marches.rough_segments),
            ShaderDefVal::UInt("SHORTEST_SEGMENT".into(), marches.shortest_segment),
            ShaderDefVal::UInt("GROWTH_PERCENT".into(), marches.growth_percent),
            ShaderDefVal::UInt("SMOOTH_STEPS".into(), marches.smooth_steps),
            ShaderDefVal::UInt("DIVISOR".into(), self.divisor),
        ];
        defs.extend(shader_defs::of_table([
            (self.specialization, "SPECIALIZATION"),
            (self.shown, "SHOWN"),
        ]));
        defs.extend(self.projection.shader_def().map(ShaderDefVal::from));
        defs
    }

    fn stands_in_for(self, wanted: Self) -> bool {
        self.projection.covers(wanted.projection)
    }
}
