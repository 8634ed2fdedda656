//! Pipeline key.

use bevy::shader::ShaderDefVal;

use crate::{
    gpu::effect_pipelines::EffectKey, shader_library::reconstruction::position::ProjectionKind,
    view::LeanQuality,
};

/// Pipeline key of all passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct SubsurfaceKey {
    /// Kernels are elongated on surfaces seen at an angle.
    is_drawn_out: bool,
    is_orthographic: bool,
}

impl SubsurfaceKey {
    pub(super) fn new(quality: LeanQuality, projection: ProjectionKind) -> Self {
        Self {
            is_drawn_out: quality >= LeanQuality::High,
            is_orthographic: projection == ProjectionKind::Orthographic,
        }
    }
}

impl EffectKey for SubsurfaceKey {
    fn shader_defs(self) -> Vec<ShaderDefVal> {
        let orthographic = ProjectionKind::Orthographic.shader_def();
        let projection = orthographic.filter(|_| self.is_orthographic);
        projection.into_iter().map(ShaderDefVal::from).collect()
    }

    /// Only passes whose kernels cover more than a few pixels name `DRAWN_OUT`.
    fn keeps_def(self, name: &str) -> bool {
        self.is_drawn_out || name != "DRAWN_OUT"
    }

    fn stands_in_for(self, wanted: Self) -> bool {
        self.is_orthographic == wanted.is_orthographic
    }
}
