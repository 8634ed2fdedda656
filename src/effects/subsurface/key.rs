//! Pipeline key.

use bevy::shader::ShaderDefVal;

use crate::{shader_library::reconstruction::position::ProjectionKind, view::LeanQuality};

/// Pipeline key of all passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct SubsurfaceKey {
    /// Kernels are elongated on surfaces seen at an angle.
    is_drawn_out: bool,
    pub(super) is_orthographic: bool,
}

impl SubsurfaceKey {
    pub(super) fn new(quality: LeanQuality, projection: ProjectionKind) -> Self {
        Self {
            is_drawn_out: quality >= LeanQuality::High,
            is_orthographic: projection == ProjectionKind::Orthographic,
        }
    }

    /// Shader defs of all passes.
    pub(super) fn shader_defs(self) -> Option<ShaderDefVal> {
        let orthographic = ProjectionKind::Orthographic.shader_def();
        let projection = orthographic.filter(|_| self.is_orthographic);
        projection.map(ShaderDefVal::from)
    }

    /// Additional shader defs of passes whose kernels cover more than a few pixels.
    pub(super) fn drawn_out(self) -> &'static [&'static str] {
        if self.is_drawn_out {
            &["DRAWN_OUT"]
        } else {
            &[]
        }
    }
}
