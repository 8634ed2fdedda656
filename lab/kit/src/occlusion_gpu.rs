//! Runs the shipped gather and filter of ambient occlusion on the device, over depth buffers made on the CPU.

mod draw;
mod shaders;
mod textures;

use std::{collections::HashMap, sync::Mutex};

use bevy::{
    math::{Mat4, UVec2},
    render::render_resource::encase::UniformBuffer,
};
use bevy_lean_deferred::effects::ambient_occlusion::{
    LeanScreenSpaceAmbientOcclusion, OcclusionUniform, binding_numbers as numbers, lattice,
};
use draw::Target;
use naga_oil::compose::ShaderDefValue;
use shaders::{
    debug_view, filter_definitions, gather, gather_definitions, shares_depths, sparse_depth,
};

use super::gpu;
use crate::wgsl::Definitions;

/// A depth buffer and its projection.
pub struct DepthImage {
    pub depth: Vec<f32>,
    pub size: UVec2,
    pub clip_from_view: Mat4,
    /// The view's part of the buffer, origin and size; by default all of it.
    pub viewport: (UVec2, UVec2),
}

impl DepthImage {
    pub fn new(depth: Vec<f32>, size: UVec2, clip_from_view: Mat4) -> Self {
        Self {
            depth,
            size,
            clip_from_view,
            viewport: (UVec2::ZERO, size),
        }
    }
}

/// Occlusion, row by row.
pub struct Occlusion {
    /// As stored: at the size of the viewport, or half of it.
    pub gathered: Vec<f32>,
    /// After the filter and `intensity`: at the size of the viewport.
    pub filtered: Vec<f32>,
}

/// The gather's two entry points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    Compute,
    Raster,
}

/// A wgpu device separate from Bevy's.
pub struct OcclusionGpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    nearest: wgpu::Sampler,
    /// Cache by source and definitions: composing takes longer than running.
    shaders: Mutex<HashMap<(String, Vec<String>), wgpu::ShaderModule>>,
}

impl OcclusionGpu {
    pub fn new() -> Self {
        let (_, device, queue) =
            gpu::request(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);
        let nearest = device.create_sampler(&wgpu::SamplerDescriptor::default());
        Self {
            device,
            queue,
            nearest,
            shaders: Mutex::default(),
        }
    }

    /// The path that the crate takes on this device.
    pub fn path(&self) -> Path {
        let stores = wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
        if self.device.features().contains(stores) {
            Path::Compute
        } else {
            Path::Raster
        }
    }

    pub fn run(&self, settings: &LeanScreenSpaceAmbientOcclusion, image: &DepthImage) -> Occlusion {
        self.run_by(self.path(), settings, image)
    }

    pub fn run_by(
        &self,
        path: Path,
        settings: &LeanScreenSpaceAmbientOcclusion,
        image: &DepthImage,
    ) -> Occlusion {
        let depth = self.depth_texture(image);
        let (origin, size) = image.viewport;
        let mut view = OcclusionUniform::new(settings, image.clip_from_view, size);
        view.viewport_origin = origin;
        let mut bytes = UniformBuffer::new(Vec::new());
        bytes.write(&view).expect("it fits");
        let uniform = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes.as_ref().len() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&uniform, 0, bytes.as_ref());

        let format = wgpu::TextureFormat::R8Unorm;
        use wgpu::TextureUsages as Usage;
        let own = match path {
            Path::Compute => Usage::STORAGE_BINDING,
            Path::Raster => Usage::RENDER_ATTACHMENT,
        };
        let stored = self.texture(
            view.texture_size,
            format,
            own | Usage::TEXTURE_BINDING | Usage::COPY_SRC,
        );
        let stored_view = stored.create_view(&Default::default());
        let depth_view = depth.create_view(&Default::default());

        let mut encoder = self.device.create_command_encoder(&Default::default());
        let common = [
            wgpu::BindGroupEntry {
                binding: numbers::VIEW,
                resource: uniform.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: numbers::DEPTH_TEXTURE,
                resource: wgpu::BindingResource::TextureView(&depth_view),
            },
            wgpu::BindGroupEntry {
                binding: numbers::NEAREST_SAMPLER,
                resource: wgpu::BindingResource::Sampler(&self.nearest),
            },
        ];
        let mut defs = gather_definitions(settings, image.clip_from_view);
        match path {
            Path::Compute => {
                defs.insert("COMPUTE".into(), ShaderDefValue::Bool(true));
                if shares_depths(settings) {
                    defs.insert("SHARED_DEPTHS".into(), ShaderDefValue::Bool(true));
                }
                let sparse = self.texture(
                    lattice::texture_size(size),
                    wgpu::TextureFormat::R32Float,
                    Usage::STORAGE_BINDING | Usage::TEXTURE_BINDING,
                );
                let sparse_view = sparse.create_view(&Default::default());
                let mut entries = common.to_vec();
                entries.push(wgpu::BindGroupEntry {
                    binding: numbers::SPARSE_DEPTH_OUTPUT,
                    resource: wgpu::BindingResource::TextureView(&sparse_view),
                });
                let output = (numbers::SPARSE_DEPTH_OUTPUT, sparse.format());
                let layout = self.layout(wgpu::ShaderStages::COMPUTE, Some(output), &[]);
                let copy = self.compute(&layout, &sparse_depth(), Definitions::new());
                let copied = self.group(&layout, &entries);

                let output = (numbers::OUTPUT_TEXTURE, format);
                let sampled = &[numbers::SPARSE_DEPTH_TEXTURE];
                let layout = self.layout(wgpu::ShaderStages::COMPUTE, Some(output), sampled);
                let mut entries = common.to_vec();
                entries.push(wgpu::BindGroupEntry {
                    binding: numbers::OUTPUT_TEXTURE,
                    resource: wgpu::BindingResource::TextureView(&stored_view),
                });
                entries.push(wgpu::BindGroupEntry {
                    binding: numbers::SPARSE_DEPTH_TEXTURE,
                    resource: wgpu::BindingResource::TextureView(&sparse_view),
                });
                let group = self.group(&layout, &entries);
                let pipeline = self.compute(&layout, &gather(), defs);
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&copy);
                pass.set_bind_group(0, &copied, &[]);
                let tiles = lattice::workgroups(size);
                pass.dispatch_workgroups(tiles.x, tiles.y, 1);
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &group, &[]);
                let tiles = view.texture_size.map(|n| n.div_ceil(16));
                pass.dispatch_workgroups(tiles.x, tiles.y, 1);
            }
            Path::Raster => {
                let layout = self.layout(wgpu::ShaderStages::FRAGMENT, None, &[]);
                let group = self.group(&layout, &common);
                self.draw(
                    &mut encoder,
                    (&layout, &group),
                    self.shader(&gather(), defs),
                    Target::Color(&stored_view, format),
                    None,
                );
            }
        }

        // The debug view shows the light that the filtered occlusion leaves.
        let shown = self.texture(
            image.size,
            wgpu::TextureFormat::R32Float,
            Usage::RENDER_ATTACHMENT | Usage::COPY_SRC,
        );
        let layout = self.layout(
            wgpu::ShaderStages::FRAGMENT,
            None,
            &[numbers::OCCLUSION_TEXTURE],
        );
        let mut entries = common.to_vec();
        entries.push(wgpu::BindGroupEntry {
            binding: numbers::OCCLUSION_TEXTURE,
            resource: wgpu::BindingResource::TextureView(&stored_view),
        });
        let group = self.group(&layout, &entries);
        self.draw(
            &mut encoder,
            (&layout, &group),
            self.shader(&debug_view(), filter_definitions(settings)),
            Target::Color(
                &shown.create_view(&Default::default()),
                wgpu::TextureFormat::R32Float,
            ),
            Some((origin, size)),
        );
        self.queue.submit([encoder.finish()]);

        let shown = self.read(&shown);
        let filtered = (0..size.y)
            .flat_map(|y| (0..size.x).map(move |x| UVec2::new(x, y)))
            .map(|p| 1.0 - shown[((origin.y + p.y) * image.size.x + origin.x + p.x) as usize])
            .collect();
        Occlusion {
            gathered: self.read(&stored),
            filtered,
        }
    }
}
