//! Capabilities of the device.

use bevy::{
    prelude::*,
    render::{
        render_resource::{DownlevelFlags, TextureFormat, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
    },
};

use crate::gpu::needed_limits::{NeededLimit, needed_limits, unmet};

/// Format of the texture of occlusion: steps of 1/255 before the filter.
pub(super) const FORMAT: TextureFormat = TextureFormat::R8Unorm;

/// Limits that the compute pass needs; without them a raster pass computes occlusion.
#[doc(hidden)]
pub const COMPUTE_LIMITS: &[NeededLimit] = &needed_limits![
    max_storage_textures_per_shader_stage: 1,
    max_compute_invocations_per_workgroup: 64,
    max_compute_workgroup_size_x: 64,
    max_compute_workgroup_storage_size: 1600,
];

/// The kind of pass that can write the texture of occlusion.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct OcclusionSupport {
    /// Compute shaders can store to `R8Unorm`. If not, it is rendered to, which every device supports.
    pub stores_r8: bool,
}

impl FromWorld for OcclusionSupport {
    /// Queries the device and adapter of a render world. Without them nothing can be stored.
    fn from_world(world: &mut World) -> Self {
        let (Some(device), Some(adapter)) = (
            world.get_resource::<RenderDevice>(),
            world.get_resource::<RenderAdapter>(),
        ) else {
            return Self { stores_r8: false };
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
        Self {
            stores_r8: computes
                && extended
                && adapter
                    .get_texture_format_features(FORMAT)
                    .allowed_usages
                    .contains(TextureUsages::STORAGE_BINDING),
        }
    }
}
