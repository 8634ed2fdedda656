//! What the device can do.

use bevy::{
    prelude::*,
    render::{
        render_resource::{DownlevelFlags, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
    },
};

use super::OcclusionFormat;
use crate::gpu::needed_limits::{NeededLimit, needed_limits, unmet};

/// Limits that the compute passes need; without them occlusion is drawn.
#[doc(hidden)]
pub const COMPUTE_LIMITS: &[NeededLimit] = &needed_limits![
    max_storage_textures_per_shader_stage: 1,
    max_compute_invocations_per_workgroup: 64,
    max_compute_workgroup_size_x: 64,
    max_compute_workgroup_storage_size: 1600,
];

/// Which formats compute shaders can store occlusion in. The others are drawn to, which every device can.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct OcclusionSupport {
    /// R8Unorm.
    pub stores_unorm8: bool,
    /// R16Float.
    pub stores_float16: bool,
}

impl FromWorld for OcclusionSupport {
    /// Looks at the device and adapter of a render world. Without them nothing can be stored.
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
        // Outside of what WebGPU guarantees, so the device must have been asked for it.
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
