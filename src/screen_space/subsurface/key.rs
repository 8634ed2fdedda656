//! What the shaders are compiled by.

use bevy::shader::ShaderDefVal;

use super::settings::SubsurfaceScatteringQuality;
use crate::shader_library::reconstruction::position::ProjectionKind;

/// What all passes are compiled by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct SubsurfaceKey {
    /// On surfaces that are turned away, kernels are drawn out.
    is_drawn_out: bool,
    pub(super) is_orthographic: bool,
}

impl SubsurfaceKey {
    /// `None` if nothing scatters.
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

    /// What all passes are compiled with.
    pub(super) fn shader_defs(self) -> Option<ShaderDefVal> {
        let orthographic = ProjectionKind::Orthographic.shader_def();
        let projection = orthographic.filter(|_| self.is_orthographic);
        projection.map(ShaderDefVal::from)
    }

    /// What those that are about kernels of more than a few pixels are compiled with beside.
    pub(super) fn drawn_out(self) -> &'static [&'static str] {
        if self.is_drawn_out {
            &["DRAWN_OUT"]
        } else {
            &[]
        }
    }
}
