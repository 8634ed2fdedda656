//! What the general pipelines bind in place of resources that a view does not have.

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
    light_layer_table::LightLayersTable,
    subsurface_light::{SUBSURFACE_LIGHT_FORMAT, SUBSURFACE_PICTURE_FORMAT},
};
use crate::gpu::storage_texture::StorageTexture;

/// Textures of one texel and buffers of zeros, one of each for all views. Shaders write to none of them: bits of
/// [`LightingParts`](super::parts::LightingParts) tell them what the view has.
#[derive(Resource)]
pub(super) struct Placeholders {
    /// As large as the largest of the uniforms and tables that it stands in for.
    pub(super) zeros: Buffer,
    /// The list of scattering tiles. Apart from `zeros`: a shader may write it.
    pub(super) scattering_tiles: Buffer,
    /// Words of the G-buffer.
    pub(super) words: StorageTexture,
    pub(super) diffuse_light: StorageTexture,
    pub(super) subsurface_light: StorageTexture,
    pub(super) subsurface_picture: StorageTexture,
}

impl FromWorld for Placeholders {
    fn from_world(world: &mut World) -> Self {
        let device = world.resource::<RenderDevice>();
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
        let largest = sizes.map(|size| size.get()).into_iter().max();
        let texture = |format| StorageTexture::new(device, label, UVec2::ONE, format);
        Self {
            zeros: buffer(
                largest.unwrap_or_default(),
                BufferUsages::UNIFORM | BufferUsages::STORAGE,
            ),
            scattering_tiles: buffer(4, BufferUsages::STORAGE),
            words: texture(TextureFormat::R32Uint),
            diffuse_light: texture(DIFFUSE_LIGHT_FORMAT),
            subsurface_light: texture(SUBSURFACE_LIGHT_FORMAT),
            subsurface_picture: texture(SUBSURFACE_PICTURE_FORMAT),
        }
    }
}
