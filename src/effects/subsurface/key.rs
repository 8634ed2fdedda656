//! Pipeline key.

use bevy::shader::ShaderDefVal;

use crate::{
    gpu::{effect_pipelines::EffectKey, shader_defs},
    view::LeanQuality,
};

/// Pipeline key of all passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct SubsurfaceKey {
    /// Kernels are elongated on surfaces seen at an angle.
    is_drawn_out: bool,
}

impl SubsurfaceKey {
    pub(super) fn new(quality: LeanQuality) -> Self {
        Self {
            is_drawn_out: quality >= LeanQuality::High,
        }
    }
}

impl EffectKey for SubsurfaceKey {
    fn shader_defs(self) -> Vec<ShaderDefVal> {
        // Only of passes whose kernels cover more than a few pixels.
        shader_defs::of_table([(self.is_drawn_out, "DRAWN_OUT")]).collect()
    }
}
