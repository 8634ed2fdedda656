//! Writes and reads textures.

use bevy::math::UVec2;

use super::{
    DepthImage, OcclusionGpu,
    draw::{Target, float_texture, layout_entry},
};
use crate::{gpu, wgsl::Definitions};

/// Draws a depth buffer: copies to one are not allowed.
const DEPTH_WRITER: &str = r"
@group(0) @binding(0) var source: texture_2d<f32>;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @builtin(frag_depth) f32 {
    return textureLoad(source, vec2<i32>(position.xy), 0).r;
}
";
const DEPTH_READER: &str = r"
@group(0) @binding(0) var depth: texture_depth_2d;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4(textureLoad(depth, vec2<i32>(position.xy), 0));
}
";

impl OcclusionGpu {
    /// An image's depths as the shaders read them: drivers clamp values drawn to a depth buffer.
    pub fn held_depth(&self, image: &DepthImage) -> Vec<f32> {
        let depth = self.depth_texture(image).create_view(&Default::default());
        let copy = self.texture(
            image.size,
            wgpu::TextureFormat::R32Float,
            wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        );
        let layout = self
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &[layout_entry(
                    0,
                    wgpu::ShaderStages::FRAGMENT,
                    wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Depth,
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    },
                )],
            });
        let group = self.group(
            &layout,
            &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&depth),
            }],
        );
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let target = Target::Color(
            &copy.create_view(&Default::default()),
            wgpu::TextureFormat::R32Float,
        );
        self.draw(
            &mut encoder,
            (&layout, &group),
            self.shader(DEPTH_READER, Definitions::new()),
            target,
            None,
        );
        self.queue.submit([encoder.finish()]);
        self.read(&copy)
    }

    pub(super) fn texture(
        &self,
        size: UVec2,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        gpu::texture(&self.device, size, format, usage)
    }

    pub(super) fn depth_texture(&self, image: &DepthImage) -> wgpu::Texture {
        use wgpu::TextureUsages as Usage;
        let source = self.texture(
            image.size,
            wgpu::TextureFormat::R32Float,
            Usage::TEXTURE_BINDING | Usage::COPY_DST,
        );
        let bytes: Vec<u8> = image.depth.iter().flat_map(|d| d.to_le_bytes()).collect();
        self.queue.write_texture(
            source.as_image_copy(),
            &bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * image.size.x),
                rows_per_image: None,
            },
            source.size(),
        );
        let depth = self.texture(
            image.size,
            wgpu::TextureFormat::Depth32Float,
            Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING,
        );
        let layout = self
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &[layout_entry(
                    0,
                    wgpu::ShaderStages::FRAGMENT,
                    float_texture(),
                )],
            });
        let group = self.group(
            &layout,
            &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(
                    &source.create_view(&Default::default()),
                ),
            }],
        );
        let mut encoder = self.device.create_command_encoder(&Default::default());
        self.draw(
            &mut encoder,
            (&layout, &group),
            self.shader(DEPTH_WRITER, Definitions::new()),
            Target::Depth(&depth.create_view(&Default::default())),
            None,
        );
        self.queue.submit([encoder.finish()]);
        depth
    }

    /// Reads the red channel.
    pub(super) fn read(&self, texture: &wgpu::Texture) -> Vec<f32> {
        let texel = texture.format().block_copy_size(None).expect("a colour");
        gpu::read_texture(&self.device, &self.queue, texture)
            .chunks(texel as usize)
            .map(|texel| match *texel {
                [unorm] => f32::from(unorm) / 255.0,
                [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
                _ => panic!("a texel of {} bytes", texel.len()),
            })
            .collect()
    }
}
