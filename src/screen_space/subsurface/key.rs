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

    pub(super) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let orthographic = ProjectionKind::Orthographic.shader_def();
        let projection = orthographic.filter(|_| self.is_orthographic);
        let drawn_out = self.is_drawn_out.then_some("DRAWN_OUT");
        let defs = projection.into_iter().chain(drawn_out);
        defs.map(ShaderDefVal::from).collect()
    }
}
