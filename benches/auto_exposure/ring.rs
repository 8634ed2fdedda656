//! The picture in many textures, so that caches hold none of it when its turn comes again.

use bevy::math::UVec2;

use crate::picture::Picture;
use kit::{exposure_gpu::ExposureGpu, gpu::texture};

/// Most textures of a ring. Only small pictures would need more, and those only serve to try the bench out.
const MOST: u64 = 16;

/// Textures that take turns.
pub struct Ring(pub Vec<wgpu::Texture>);

impl Ring {
    /// Creates as many copies of `picture` as make up `megabytes`, at least 2. With 0 there is a single one, which
    /// caches may hold.
    pub fn new(gpu: &ExposureGpu, picture: &Picture, megabytes: u64) -> Self {
        let needed = (megabytes * 1_000_000).div_ceil(picture.bytes.len() as u64);
        let count = match megabytes {
            0 => 1,
            _ => needed.clamp(2, MOST),
        };
        // The usages of Bevy's main textures.
        let usage = wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST;
        let ring = Self::empty(gpu, picture.size, count as usize, usage);
        for texture in &ring.0 {
            gpu.queue.write_texture(
                texture.as_image_copy(),
                &picture.bytes,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(8 * texture.width()),
                    rows_per_image: None,
                },
                texture.size(),
            );
            // Frees the staging memory of the upload.
            gpu.queue.submit([]);
            gpu.device
                .poll(wgpu::PollType::wait_indefinitely())
                .unwrap_or_else(|error| panic!("the device did not finish: {error}"));
        }
        ring
    }

    pub fn empty(gpu: &ExposureGpu, size: UVec2, count: usize, usage: wgpu::TextureUsages) -> Self {
        let make = || texture(&gpu.device, size, wgpu::TextureFormat::Rgba16Float, usage);
        Self((0..count).map(|_| make()).collect())
    }
}
