//! Checks the device for the capabilities that lean cameras need.

use bevy::{
    prelude::*,
    render::{
        render_resource::{DownlevelFlags, TextureFormat, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
    },
};

use crate::{
    gpu::needed_limits::{NeededLimit, lacking, needed_limits},
    shader_library::layout::{NORMAL_FORMAT, SURFACE_FORMAT, VALID_MASK_FORMAT},
};

/// Checks the device of `world` for what [`LeanDeferred`](crate::LeanDeferred) needs. Without a device, the device itself
/// is missing.
pub(super) fn check(world: &World) -> Result<(), String> {
    let (Some(device), Some(adapter)) = (
        world.get_resource::<RenderDevice>(),
        world.get_resource::<RenderAdapter>(),
    ) else {
        return Err("a render device".into());
    };
    let missing = missing_capabilities(device, adapter);
    if missing.is_empty() {
        Ok(())
    } else {
        Err(missing.join(", "))
    }
}

/// Flags of the adapter that [`LeanDeferred`](crate::LeanDeferred) needs.
#[doc(hidden)]
pub const NEEDED_FLAGS: [(DownlevelFlags, &str); 3] = [
    (DownlevelFlags::COMPUTE_SHADERS, "compute shaders"),
    (DownlevelFlags::SHADER_F16_IN_F32, "packing of half floats"),
    // Meshes write only some of the optional targets.
    (
        DownlevelFlags::INDEPENDENT_BLEND,
        "a write mask for each render target",
    ),
];

/// Usages of formats that [`LeanDeferred`](crate::LeanDeferred) needs.
#[doc(hidden)]
pub const NEEDED_FORMATS: [(TextureFormat, TextureUsages, &str); 6] = [
    (
        TextureFormat::Rgba16Float,
        TextureUsages::STORAGE_BINDING,
        "Rgba16Float as a storage texture",
    ),
    (
        TextureFormat::Rgba16Float,
        TextureUsages::RENDER_ATTACHMENT,
        "Rgba16Float as a render target",
    ),
    (
        SURFACE_FORMAT,
        TextureUsages::RENDER_ATTACHMENT,
        "R32Uint as a render target",
    ),
    (
        NORMAL_FORMAT,
        TextureUsages::TEXTURE_BINDING,
        "R32Uint as a texture",
    ),
    (
        SURFACE_FORMAT,
        TextureUsages::STORAGE_BINDING,
        "R32Uint as a storage texture",
    ),
    (
        VALID_MASK_FORMAT,
        TextureUsages::RENDER_ATTACHMENT,
        "R8Uint as a render target",
    ),
];

/// Limits that [`LeanDeferred`](crate::LeanDeferred) needs. `tests/shaders/twins/limits.rs` compares them with its shaders.
#[doc(hidden)]
pub const NEEDED_LIMITS: &[NeededLimit] = &needed_limits![
    // One for the picture, three for GI and scattering. Every device with storage textures has four.
    max_storage_textures_per_shader_stage: 4,
    // Bevy keeps lights and clusters in storage buffers only from 3 on; the compute pass has no other path. Decals, the
    // atmosphere, the light layers and the tile list of special surfaces need one, one, one and two more.
    max_storage_buffers_per_shader_stage: 8,
    max_color_attachments: 7,
    // Six words, and the `valid_mask` byte, which alignment pads to a word.
    max_color_attachment_bytes_per_sample: 28,
    max_bind_groups: 4,
    max_compute_invocations_per_workgroup: 64,
    max_compute_workgroup_size_x: 64,
];

/// Returns the capabilities that `device` lacks for [`LeanDeferred`](crate::LeanDeferred). This is the only such check.
pub fn missing_capabilities(device: &RenderDevice, adapter: &RenderAdapter) -> Vec<String> {
    missing_of(
        adapter.get_downlevel_capabilities().flags,
        |format| adapter.get_texture_format_features(format).allowed_usages,
        &device.limits(),
    )
}

/// Like [`missing_capabilities`], for any device.
#[doc(hidden)]
pub fn missing_of(
    flags: DownlevelFlags,
    usages: impl Fn(TextureFormat) -> TextureUsages,
    limits: &wgpu::Limits,
) -> Vec<String> {
    let flags = (NEEDED_FLAGS.iter())
        .filter(|(flag, _)| !flags.contains(*flag))
        .map(|(_, name)| (*name).into());
    let formats = (NEEDED_FORMATS.iter())
        .filter(|(format, usage, _)| !usages(*format).contains(*usage))
        .map(|(.., name)| (*name).into());
    let limits = lacking(NEEDED_LIMITS, limits);
    flags.chain(formats).chain(limits).collect()
}
