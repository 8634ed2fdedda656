//! Pipeline keys.

use bevy::{render::render_resource::TextureFormat, shader::ShaderDefVal};

use super::settings::{LeanScreenSpaceAmbientOcclusion, OcclusionKernel};
use crate::{shader_library::reconstruction::position::ProjectionKind, view::LeanResolution};

/// Pipeline key of the gather.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct GatherKey {
    pub(super) kernel: OcclusionKernel,
    /// Slices, and steps on either side of each.
    pub(super) samples: (u32, u32),
    pub(super) shading_normals: bool,
    /// Horizons decay behind thin occluders.
    pub(super) thin: bool,
    /// Directions are spread over 4×4 pixels, for a wide filter; otherwise over 2×2.
    pub(super) wide: bool,
    pub(super) divisor: u32,
    pub(super) projection: ProjectionKind,
}

impl GatherKey {
    /// Resets the fields that the kernel does not read.
    pub(super) fn reduced(mut self) -> Self {
        if self.kernel == OcclusionKernel::Hdao {
            self.samples = (0, 0);
            self.shading_normals = false;
            self.thin = false;
            self.wide = false;
        }
        self
    }

    pub(super) fn reads_normals(self) -> bool {
        self.reduced().shading_normals
    }

    /// True if workgroups of the compute pass load depth into workgroup memory. Needs full resolution, where the pixels are contiguous.
    pub(super) fn shares_depths(self) -> bool {
        self.kernel == OcclusionKernel::Hbao && self.divisor == 1
    }

    pub(super) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let (slices, steps) = self.samples;
        let mut defs = vec![
            ShaderDefVal::UInt("DIVISOR".into(), self.divisor),
            ShaderDefVal::UInt("SLICES".into(), slices),
            ShaderDefVal::UInt("STEPS".into(), steps),
        ];
        let mut define = |condition: bool, name: &'static str| {
            if condition {
                defs.push(name.into());
            }
        };
        define(self.kernel == OcclusionKernel::Hdao, "HDAO");
        define(self.shading_normals, "SHADING_NORMALS");
        define(self.thin, "THIN");
        define(self.wide, "WIDE_PATTERN");
        defs.extend(self.projection.shader_def().map(ShaderDefVal::from));
        defs
    }
}

/// Pipeline key of the filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct FilterKey {
    wide: bool,
    edge_aware: bool,
    half: bool,
}

impl From<&LeanScreenSpaceAmbientOcclusion> for FilterKey {
    fn from(settings: &LeanScreenSpaceAmbientOcclusion) -> Self {
        Self {
            wide: settings.has_wide_pattern(),
            edge_aware: settings.advanced.edge_aware,
            half: settings.resolution == LeanResolution::Half,
        }
    }
}

impl FilterKey {
    pub(crate) fn shader_defs(self) -> impl Iterator<Item = ShaderDefVal> {
        [
            (self.wide, "OCCLUSION_WIDE"),
            (self.edge_aware, "OCCLUSION_EDGE_AWARE"),
            (self.half, "OCCLUSION_HALF"),
        ]
        .into_iter()
        .filter(|(condition, _)| *condition)
        .map(|(_, name)| name.into())
    }
}

/// Pipeline key of the merge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct MergeKey {
    pub(super) target: TextureFormat,
    pub(super) filter: FilterKey,
    pub(super) fog: bool,
}
