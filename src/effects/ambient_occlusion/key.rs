//! Pipeline keys.

use bevy::{render::render_resource::TextureFormat, shader::ShaderDefVal};

use super::settings::{
    LeanScreenSpaceAmbientOcclusion, OcclusionFilter, OcclusionKernel, OcclusionNormals,
};
use crate::{
    gpu::shader_defs,
    shader_library::reconstruction::position::ProjectionKind,
    view::{LeanResolution, LightingIo},
};

/// Pipeline key of the gather.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct GatherKey {
    pub(super) kernel: OcclusionKernel,
    /// Slices, and steps on either side of each.
    pub(super) samples: (u32, u32),
    pub(super) shading_normals: bool,
    /// Horizons decay behind thin occluders.
    pub(super) thin: bool,
    /// A compute pass; otherwise a raster pass.
    pub(super) computes: bool,
    /// Workgroups of the compute pass load depth into workgroup memory. Needs full resolution, where the pixels are contiguous.
    pub(super) shares_depths: bool,
    pub(super) projection: ProjectionKind,
}

impl GatherKey {
    pub(super) fn new(
        settings: &LeanScreenSpaceAmbientOcclusion,
        is_for_lighting: bool,
        computes: bool,
        projection: ProjectionKind,
    ) -> Self {
        let kernel = settings.advanced.kernel;
        if kernel == OcclusionKernel::Hdao {
            // It reads none of the other settings.
            return Self {
                kernel,
                samples: (0, 0),
                shading_normals: false,
                thin: false,
                computes,
                shares_depths: false,
                projection,
            };
        }
        Self {
            kernel,
            samples: settings.samples(),
            // After the opaque meshes, the G-buffer's normals may be of surfaces that forward meshes have covered.
            shading_normals: is_for_lighting
                && settings.advanced.normals == OcclusionNormals::Shading,
            thin: settings.thickness.is_some(),
            computes,
            shares_depths: computes && settings.resolution == LeanResolution::Full,
            projection,
        }
    }

    /// True if distant samples read sparse depth, which a compute pass stores before the gather.
    pub(super) fn reads_sparse_depth(self) -> bool {
        self.computes && self.kernel == OcclusionKernel::Hbao
    }

    pub(super) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let (slices, steps) = self.samples;
        let mut defs = vec![
            ShaderDefVal::UInt("SLICES".into(), slices),
            ShaderDefVal::UInt("STEPS".into(), steps),
        ];
        defs.extend(shader_defs::of_table([
            (self.computes, "COMPUTE"),
            (self.shares_depths, "SHARED_DEPTHS"),
            (self.kernel == OcclusionKernel::Hdao, "HDAO"),
            (self.shading_normals, "SHADING_NORMALS"),
            (self.thin, "THIN"),
        ]));
        defs.extend(self.projection.shader_def().map(ShaderDefVal::from));
        defs
    }
}

impl LeanScreenSpaceAmbientOcclusion {
    /// Flags of the lighting pipeline that applies the occlusion.
    pub(super) fn lighting_io(&self) -> LightingIo {
        [
            (true, LightingIo::AMBIENT_OCCLUSION),
            (self.has_wide_pattern(), LightingIo::OCCLUSION_WIDE),
            (self.advanced.edge_aware, LightingIo::OCCLUSION_EDGE_AWARE),
            (
                self.resolution == LeanResolution::Half,
                LightingIo::OCCLUSION_HALF,
            ),
            (self.advanced.multibounce, LightingIo::OCCLUSION_MULTIBOUNCE),
            (
                self.direct_light > 0.0,
                LightingIo::OCCLUSION_OF_DIRECT_LIGHT,
            ),
        ]
        .into_iter()
        .filter_map(|(is_asked, what)| is_asked.then_some(what))
        .collect()
    }

    /// These settings with the resolution and the pattern that lighting with `io` filters: while it compiles for others,
    /// those of before.
    pub(super) fn as_lit(mut self, io: LightingIo) -> Self {
        self.resolution = if io.contains(LightingIo::OCCLUSION_HALF) {
            LeanResolution::Half
        } else {
            LeanResolution::Full
        };
        self.advanced.filter = if io.contains(LightingIo::OCCLUSION_WIDE) {
            OcclusionFilter::Wide
        } else {
            OcclusionFilter::Narrow
        };
        self
    }
}

/// Pipeline key of the merge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct MergeKey {
    pub(super) target: TextureFormat,
    /// The bits that the filter is compiled by.
    pub(super) filter: LightingIo,
}

impl MergeKey {
    pub(super) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let filter = self.filter.occlusion_defs();
        filter.map(ShaderDefVal::from).collect()
    }
}

#[cfg(test)]
mod tests {
    use bevy::prelude::default;

    use super::*;

    #[test]
    fn occlusion_is_gathered_as_lighting_filters_it() {
        for resolution in LeanResolution::ALL {
            for filter in OcclusionFilter::ALL {
                let mut former = LeanScreenSpaceAmbientOcclusion {
                    resolution,
                    ..default()
                };
                former.advanced.filter = filter;
                for resolution in LeanResolution::ALL {
                    let settings = LeanScreenSpaceAmbientOcclusion {
                        resolution,
                        ..default()
                    };
                    let lit = settings.as_lit(former.lighting_io());
                    assert_eq!(lit.lighting_io(), former.lighting_io());
                }
            }
        }
    }
}
