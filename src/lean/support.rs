use bevy::{
    prelude::*,
    render::{
        render_resource::{DownlevelFlags, TextureFormat, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
    },
};

use crate::shader_library::layout::{NORMAL_FORMAT, SURFACE_FORMAT};

/// Whether this device can run [`LeanDeferred`](crate::LeanDeferred). In the render world, from
/// `RenderStartup` on.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub enum LeanDeferredSupport {
    /// It can.
    Full,
    /// It cannot; the text names what is missing.
    Missing(String),
}

impl LeanDeferredSupport {
    /// Looks at the device and adapter of a render world. Without them everything is missing.
    fn from_world(world: &World) -> Self {
        let (Some(device), Some(adapter)) = (
            world.get_resource::<RenderDevice>(),
            world.get_resource::<RenderAdapter>(),
        ) else {
            return Self::Missing("a render device".into());
        };
        let missing = missing_capabilities(device, adapter);
        if missing.is_empty() {
            Self::Full
        } else {
            Self::Missing(missing.join(", "))
        }
    }
}

/// Looks at the device, each time there is a new one.
pub(super) fn init_lean_deferred_support(world: &mut World) {
    let support = LeanDeferredSupport::from_world(world);
    if let LeanDeferredSupport::Missing(missing) = &support {
        warn!("LeanDeferred is off, cameras render as Bevy has them. The device lacks: {missing}");
    }
    world.insert_resource(support);
}

/// The one list of what [`LeanDeferred`](crate::LeanDeferred) needs; returns what `device` does not have of it.
pub fn missing_capabilities(device: &RenderDevice, adapter: &RenderAdapter) -> Vec<String> {
    let mut missing = Vec::new();

    let flags = adapter.get_downlevel_capabilities().flags;
    for (flag, name) in [
        (DownlevelFlags::COMPUTE_SHADERS, "compute shaders"),
        (DownlevelFlags::SHADER_F16_IN_F32, "packing of half floats"),
    ] {
        if !flags.contains(flag) {
            missing.push(name.into());
        }
    }

    for (format, usage, name) in [
        (
            TextureFormat::Rgba16Float,
            TextureUsages::STORAGE_BINDING,
            "Rgba16Float as a storage texture",
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
    ] {
        let allowed = adapter.get_texture_format_features(format).allowed_usages;
        if !allowed.contains(usage) {
            missing.push(name.into());
        }
    }

    let limits = device.limits();
    for (have, need, name) in [
        // Lighting writes the picture; what it writes for GI and scattering, and the levels that effects make at once, need three more.
        // Every device has them that has any.
        (
            limits.max_storage_textures_per_shader_stage,
            4,
            "max_storage_textures_per_shader_stage",
        ),
        // Bevy keeps lights and clusters in storage buffers only from 3 on; the compute pass has no other path. Decals,
        // the atmosphere, the lights' layers and the lists of special surfaces' tiles need one, one, one and two more.
        (
            limits.max_storage_buffers_per_shader_stage,
            8,
            "max_storage_buffers_per_shader_stage",
        ),
        (limits.max_color_attachments, 7, "max_color_attachments"),
        (limits.max_bind_groups, 4, "max_bind_groups"),
        (
            limits.max_compute_invocations_per_workgroup,
            64,
            "max_compute_invocations_per_workgroup",
        ),
    ] {
        if have < need {
            missing.push(format!("{name} of {need} (it has {have})"));
        }
    }
    missing
}
