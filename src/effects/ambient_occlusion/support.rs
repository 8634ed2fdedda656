//! Capabilities of the device.

use bevy::{
    prelude::*,
    render::{
        render_resource::{DownlevelFlags, TextureFormat, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
    },
};

use crate::gpu::needed_limits::{NeededLimit, check_limits, needed_limits};

/// Format of the texture of occlusion: steps of 1/255 before the filter.
pub(super) const FORMAT: TextureFormat = TextureFormat::R8Unorm;

/// Format of sparse depth: exact.
pub(super) const SPARSE_DEPTH_FORMAT: TextureFormat = TextureFormat::R32Float;

/// Limits that the compute pass needs; without them a raster pass computes occlusion.
#[doc(hidden)]
pub const COMPUTE_LIMITS: &[NeededLimit] = &needed_limits![
    max_storage_textures_per_shader_stage: 1,
    max_compute_invocations_per_workgroup: 64,
    max_compute_workgroup_size_x: 64,
    max_compute_workgroup_storage_size: 1600,
];

/// Checks if compute shaders of the device of `world` can store to the texture. If not, it is rendered to, which every
/// device supports.
pub(super) fn check_compute(world: &World) -> Result<(), String> {
    let (Some(device), Some(adapter)) = (
        world.get_resource::<RenderDevice>(),
        world.get_resource::<RenderAdapter>(),
    ) else {
        return Err("a render device".into());
    };
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(DownlevelFlags::COMPUTE_SHADERS) {
        return Err("compute shaders".into());
    }
    check_limits(COMPUTE_LIMITS, &device.limits())?;
    // Beyond WebGPU's guarantees, so the device must have been created with this feature.
    let extended = device
        .features()
        .contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);
    let usages = adapter.get_texture_format_features(FORMAT).allowed_usages;
    if extended && usages.contains(TextureUsages::STORAGE_BINDING) {
        Ok(())
    } else {
        Err("R8Unorm as a storage texture".into())
    }
}
