//! Placeholders that pipelines bind for resources that a view does not have.

use bevy::{
    pbr::{GpuFog, contact_shadows::ContactShadowsUniform, resources::GpuAtmosphere},
    prelude::*,
    render::{
        render_resource::{Buffer, BufferDescriptor, BufferUsages, ShaderType, TextureFormat},
        renderer::RenderDevice,
    },
};

use super::{
    diffuse_light::DIFFUSE_LIGHT_FORMAT,
    features::LightingKey,
    light_layer_table::LightLayersTable,
    subsurface_light::{SUBSURFACE_LIGHT_FORMAT, SUBSURFACE_PICTURE_FORMAT},
};
use crate::gpu::storage_texture::StorageTexture;

/// Textures of one texel and buffers of zeros, one of each for all views. Shaders write to none of them: bits of
/// [`LightingParts`](super::parts::LightingParts) tell them what the view has.
pub(super) struct Placeholders {
    /// As large as the largest of the uniforms and tables that it stands in for.
    pub(super) zeros: Buffer,
    /// Words of the G-buffer.
    pub(super) words: StorageTexture,
    pub(super) diffuse_light: StorageTexture,
    /// `None` if general pipelines do not scatter light.
    pub(super) scattering: Option<ScatteringPlaceholders>,
}

/// Placeholders for the light that enters scattering surfaces.
pub(super) struct ScatteringPlaceholders {
    pub(super) light: StorageTexture,
    pub(super) picture: StorageTexture,
    /// Apart from [`Placeholders::zeros`]: a shader may write it.
    pub(super) tiles: Buffer,
}

impl Placeholders {
    /// Creates those for general pipelines with the parts of `room`.
    pub(super) fn new(device: &RenderDevice, room: LightingKey) -> Self {
        let label = "lean_deferred/lighting/placeholder";
        let buffer = |size, usage| {
            device.create_buffer(&BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let sizes = [
            GpuFog::min_size(),
            ContactShadowsUniform::min_size(),
            GpuAtmosphere::min_size(),
            LightLayersTable::min_size(),
        ];
        let largest = sizes.into_iter().max().map_or(0, |size| size.get());
        let texture = |format| StorageTexture::new(device, label, UVec2::ONE, format);
        Self {
            zeros: buffer(largest, BufferUsages::UNIFORM | BufferUsages::STORAGE),
            words: texture(TextureFormat::R32Uint),
            diffuse_light: texture(DIFFUSE_LIGHT_FORMAT),
            scattering: room.scatters.then(|| ScatteringPlaceholders {
                light: texture(SUBSURFACE_LIGHT_FORMAT),
                picture: texture(SUBSURFACE_PICTURE_FORMAT),
                tiles: buffer(4, BufferUsages::STORAGE),
            }),
        }
    }
}
