//! Textures that one pass writes and another reads.

use bevy::{
    image::ToExtents,
    prelude::*,
    render::{
        render_resource::{
            Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
            TextureView, TextureViewDescriptor,
        },
        renderer::RenderDevice,
    },
};

/// A texture with `LEVELS` mips.
pub(crate) struct StorageTexture<const LEVELS: usize = 1> {
    pub(crate) texture: Texture,
    /// All mips, for reading.
    pub(crate) view: TextureView,
    /// Each mip, for writing.
    pub(crate) levels: [TextureView; LEVELS],
}

impl<const LEVELS: usize> StorageTexture<LEVELS> {
    /// `size` is that of mip 0, enlarged if needed so that the last mip has a texel per axis.
    pub(crate) fn new(
        device: &RenderDevice,
        label: &'static str,
        size: UVec2,
        format: TextureFormat,
    ) -> Self {
        let texture = device.create_texture(&TextureDescriptor {
            label: Some(label),
            size: size.max(UVec2::splat(1 << (LEVELS - 1))).to_extents(),
            mip_level_count: LEVELS as u32,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: TextureUsages::STORAGE_BINDING
                | TextureUsages::TEXTURE_BINDING
                | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Self {
            view: texture.create_view(&TextureViewDescriptor::default()),
            levels: core::array::from_fn(|level| {
                texture.create_view(&TextureViewDescriptor {
                    base_mip_level: level as u32,
                    mip_level_count: Some(1),
                    ..default()
                })
            }),
            texture,
        }
    }
}
