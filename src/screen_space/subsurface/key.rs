//! Pipeline key.

use bevy::shader::ShaderDefVal;

use super::settings::SubsurfaceScatteringQuality;
use crate::shader_library::reconstruction::position::ProjectionKind;

/// Pipeline key of all passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct SubsurfaceKey {
    /// Kernels are elongated on surfaces seen at an angle.
    is_drawn_out: bool,
    pub(super) is_orthographic: bool,
}

impl SubsurfaceKey {
    /// `None` if scattering is off.
    pub(super) fn new(
        quality: SubsurfaceScatteringQuality,
        projection: ProjectionKind,
    ) -> Option<Self> {
        let is_drawn_out = match quality {
            SubsurfaceScatteringQuality::Off => return None,
            SubsurfaceScatteringQuality::Low => false,
            SubsurfaceScatteringQuality::High => true,
        };
        Some(Self {
            is_drawn_out,
            is_orthographic: projection == ProjectionKind::Orthographic,
        })
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
