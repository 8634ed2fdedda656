//! Capabilities of the device.

use bevy::{
    prelude::*,
    render::{
        render_resource::{DownlevelFlags, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
    },
};

use super::OcclusionFormat;
use crate::gpu::needed_limits::{NeededLimit, needed_limits, unmet};

/// Limits that the compute pass needs; without them a raster pass computes occlusion.
#[doc(hidden)]
pub const COMPUTE_LIMITS: &[NeededLimit] = &needed_limits![
    max_storage_textures_per_shader_stage: 1,
    max_compute_invocations_per_workgroup: 64,
    max_compute_workgroup_size_x: 64,
    max_compute_workgroup_storage_size: 1600,
];

/// Occlusion formats that compute shaders can store to. The others are rendered to, which every device supports.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct OcclusionSupport {
    /// R8Unorm.
    pub stores_unorm8: bool,
    /// R16Float.
    pub stores_float16: bool,
}

impl FromWorld for OcclusionSupport {
    /// Queries the device and adapter of a render world. Without them no format can be stored to.
    fn from_world(world: &mut World) -> Self {
        let (Some(device), Some(adapter)) = (
            world.get_resource::<RenderDevice>(),
            world.get_resource::<RenderAdapter>(),
        ) else {
            return Self {
                stores_unorm8: false,
                stores_float16: false,
            };
        };
        let computes = adapter
            .get_downlevel_capabilities()
            .flags
            .contains(DownlevelFlags::COMPUTE_SHADERS)
            && unmet(COMPUTE_LIMITS, &device.limits()).next().is_none();
        // Beyond WebGPU's guarantees, so the device must have been created with this feature.
        let extended = device
            .features()
            .contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);
        let can_store = |format: OcclusionFormat| {
            computes
                && extended
                && adapter
                    .get_texture_format_features(format.texture_format())
                    .allowed_usages
                    .contains(TextureUsages::STORAGE_BINDING)
        };
        Self {
            stores_unorm8: can_store(OcclusionFormat::Unorm8),
            stores_float16: can_store(OcclusionFormat::Float16),
        }
    }
}

impl OcclusionSupport {
    pub(super) fn can_store(self, format: OcclusionFormat) -> bool {
        match format {
            OcclusionFormat::Unorm8 => self.stores_unorm8,
            OcclusionFormat::Float16 => self.stores_float16,
        }
    }
}
