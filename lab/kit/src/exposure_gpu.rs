//! Runs the shipped shaders of auto exposure on the device, over pictures made on the CPU.

use std::{collections::HashMap, sync::Mutex};

use bevy::{
    math::{UVec2, Vec3},
    render::render_resource::encase::{StorageBuffer, UniformBuffer},
};
use bevy_lean_deferred::effects::auto_exposure::{
    ExposureKey, ExposureState, ExposureUniform, LeanAutoExposure, MeteringPattern,
    binding_numbers as numbers, key::workgroups, layouts,
};
use half::f16;

use super::gpu;
use crate::{
    shader_files::shader_file,
    wgsl::{WgslModule, compile, definitions_of, key_of, wgsl},
};

/// Modules that the shaders import, dependencies first.
const MODULES: [WgslModule; 7] = [
    wgsl!("shader_library/tiles.wgsl"),
    BEVY_VIEW,
    wgsl!("effects/auto_exposure/bindings.wgsl"),
    wgsl!("effects/auto_exposure/luminance.wgsl"),
    wgsl!("effects/auto_exposure/pattern.wgsl"),
    wgsl!("effects/auto_exposure/adaptation.wgsl"),
    wgsl!("effects/auto_exposure/reduction.wgsl"),
];
/// Replaces Bevy's view module, as far as the shaders use it.
const BEVY_VIEW: WgslModule = WgslModule {
    path: "Bevy's view",
    source: "
#define_import_path bevy_render::view
struct ColorGrading { exposure: f32 }
struct View { color_grading: ColorGrading }
",
};
const METER: WgslModule = wgsl!("effects/auto_exposure/meter.wgsl");
const ADAPT: WgslModule = wgsl!("effects/auto_exposure/adapt.wgsl");

/// Bound bytes of Bevy's view.
const BEVY_VIEW_SIZE: u64 = 4096;

/// A wgpu device separate from Bevy's.
pub struct ExposureGpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub adapter: wgpu::AdapterInfo,
    /// Cache by path and definitions: composing takes longer than running.
    shaders: Mutex<HashMap<(&'static str, Vec<String>), wgpu::ShaderModule>>,
}

impl ExposureGpu {
    pub fn new() -> Self {
        let (adapter, device, queue) = gpu::request(
            wgpu::Features::SUBGROUP
                | wgpu::Features::TIMESTAMP_QUERY
                | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS
                | wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES,
        );
        Self {
            device,
            queue,
            adapter,
            shaders: Mutex::default(),
        }
    }

    pub fn has(&self, features: wgpu::Features) -> bool {
        self.device.features().contains(features)
    }

    pub fn has_subgroups(&self) -> bool {
        self.has(wgpu::Features::SUBGROUP)
    }

    /// Creates a picture in the format of Bevy's main textures.
    pub fn picture(&self, size: UVec2, texels: &[Vec3]) -> wgpu::Texture {
        self.texture(
            size,
            wgpu::TextureFormat::Rgba16Float,
            &texel_bytes(texels),
            8,
        )
    }

    pub fn overwrite(&self, picture: &wgpu::Texture, texels: &[Vec3]) {
        self.write(picture, &texel_bytes(texels), 8);
    }

    /// Creates an 8-bit metering mask.
    pub fn mask(&self, size: UVec2, texels: &[u8]) -> wgpu::Texture {
        self.texture(size, wgpu::TextureFormat::R8Unorm, texels, 1)
    }

    /// Creates a half-precision metering mask.
    pub fn float_mask(&self, size: UVec2, texels: &[f32]) -> wgpu::Texture {
        let bytes: Vec<u8> = texels
            .iter()
            .flat_map(|texel| f16::from_f32(*texel).to_le_bytes())
            .collect();
        self.texture(size, wgpu::TextureFormat::R16Float, &bytes, 2)
    }

    fn texture(
        &self,
        size: UVec2,
        format: wgpu::TextureFormat,
        bytes: &[u8],
        texel_size: u32,
    ) -> wgpu::Texture {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = gpu::texture(&self.device, size, format, usage);
        self.write(&texture, bytes, texel_size);
        texture
    }

    fn write(&self, texture: &wgpu::Texture, bytes: &[u8], texel_size: u32) {
        self.queue.write_texture(
            texture.as_image_copy(),
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(texel_size * texture.width()),
                rows_per_image: None,
            },
            texture.size(),
        );
    }

    pub fn buffer(&self, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    pub fn bind_group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[(u32, wgpu::BindingResource)],
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = resources
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: resource.clone(),
            })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &entries,
        })
    }

    /// Reads a buffer after all submitted work.
    pub fn read(&self, buffer: &wgpu::Buffer) -> Vec<u8> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let readback = self.buffer(buffer.size(), usage);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &readback, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        readback.map_async(wgpu::MapMode::Read, .., |mapped| {
            mapped.unwrap_or_else(|error| panic!("the results cannot be read: {error}"));
        });
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .unwrap_or_else(|error| panic!("the device did not finish: {error}"));
        readback.get_mapped_range(..).to_vec()
    }

    fn shader(&self, module: &WgslModule, key: ExposureKey) -> wgpu::ShaderModule {
        let definitions = definitions_of(key.shader_defs());
        let mut shaders = self
            .shaders
            .lock()
            .expect("no test panics while it composes");
        let shader = shaders.entry((module.path, key_of(&definitions)));
        shader
            .or_insert_with(|| compile(&self.device, &MODULES, &shader_file(module), definitions))
            .clone()
    }

    pub fn pipeline(
        &self,
        layout: &wgpu::BindGroupLayout,
        shader: &wgpu::ShaderModule,
        entry_point: &str,
    ) -> wgpu::ComputePipeline {
        let layout = self
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(layout)],
                immediate_size: 0,
            });
        self.device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: None,
                layout: Some(&layout),
                module: shader,
                entry_point: Some(entry_point),
                compilation_options: Default::default(),
                cache: None,
            })
    }
}

fn texel_bytes(texels: &[Vec3]) -> Vec<u8> {
    texels
        .iter()
        .flat_map(|texel| [texel.x, texel.y, texel.z, 1.0])
        .flat_map(|channel| f16::from_f32(channel).to_le_bytes())
        .collect()
}

/// One camera's pipelines, buffers and state.
pub struct Meter<'a> {
    gpu: &'a ExposureGpu,
    settings: LeanAutoExposure,
    key: ExposureKey,
    viewport: (UVec2, UVec2),
    uniform: wgpu::Buffer,
    bevy_view: wgpu::Buffer,
    state: wgpu::Buffer,
    passes: [(wgpu::ComputePipeline, wgpu::BindGroup); 2],
}

impl<'a> Meter<'a> {
    /// A camera that has not rendered yet and sees `viewport` (origin and size) of `picture`.
    pub fn new(
        gpu: &'a ExposureGpu,
        settings: &LeanAutoExposure,
        subgroups: bool,
        picture: &wgpu::Texture,
        viewport: (UVec2, UVec2),
        mask: Option<&wgpu::Texture>,
    ) -> Self {
        assert_eq!(
            mask.is_some(),
            matches!(settings.pattern, MeteringPattern::Mask(_))
        );
        let key = ExposureKey::new(settings, subgroups, mask.is_some());
        let pipeline = |entries: &[wgpu::BindGroupLayoutEntry], source, entry_point| {
            let layout = gpu
                .device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: None,
                    entries,
                });
            gpu.pipeline(&layout, &gpu.shader(source, key), entry_point)
        };
        let [meter, adapt] = layouts();
        let pipelines = [
            pipeline(&meter.entries, &METER, "meter"),
            pipeline(&adapt.entries, &ADAPT, "sum_and_adapt"),
        ];
        Self::with_pipelines(
            gpu,
            settings.clone(),
            key,
            pipelines,
            picture,
            viewport,
            mask,
        )
    }

    /// A camera of the same settings that sees the same viewport of another picture. Reuses the pipelines.
    pub fn another(&self, picture: &wgpu::Texture, mask: Option<&wgpu::Texture>) -> Self {
        let pipelines = self.passes.each_ref().map(|(pipeline, _)| pipeline.clone());
        Self::with_pipelines(
            self.gpu,
            self.settings.clone(),
            self.key,
            pipelines,
            picture,
            self.viewport,
            mask,
        )
    }

    fn with_pipelines(
        gpu: &'a ExposureGpu,
        settings: LeanAutoExposure,
        key: ExposureKey,
        [meter, adapt]: [wgpu::ComputePipeline; 2],
        picture: &wgpu::Texture,
        viewport: (UVec2, UVec2),
        mask: Option<&wgpu::Texture>,
    ) -> Self {
        use wgpu::BufferUsages as Usage;
        let uniform_size =
            <ExposureUniform as bevy::render::render_resource::ShaderType>::min_size();
        let uniform = gpu.buffer(uniform_size.get(), Usage::UNIFORM | Usage::COPY_DST);
        let sums = gpu.buffer(key.sums_size(viewport.1), Usage::STORAGE);
        let read_write = Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC;
        let bevy_view = gpu.buffer(BEVY_VIEW_SIZE, read_write);
        let state = gpu.buffer(16, read_write);
        let picture = picture.create_view(&Default::default());

        use wgpu::BindingResource::{Sampler, TextureView};
        let no_mask = gpu.mask(UVec2::ONE, &[255]);
        let mask = mask.unwrap_or(&no_mask);
        let mask = mask.create_view(&Default::default());
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let resources = [
            (numbers::VIEW, uniform.as_entire_binding()),
            (numbers::PICTURE, TextureView(&picture)),
            (numbers::PARTIALS, sums.as_entire_binding()),
            (numbers::MASK, TextureView(&mask)),
            (numbers::MASK_SAMPLER, Sampler(&sampler)),
        ];
        let meter_group = gpu.bind_group(&meter.get_bind_group_layout(0), &resources);
        let adapt_group = gpu.bind_group(
            &adapt.get_bind_group_layout(0),
            &[
                (numbers::VIEW, uniform.as_entire_binding()),
                (numbers::PARTIALS, sums.as_entire_binding()),
                (numbers::STATE, state.as_entire_binding()),
                (numbers::BEVY_VIEW, bevy_view.as_entire_binding()),
            ],
        );
        Self {
            gpu,
            settings,
            key,
            viewport,
            uniform,
            bevy_view,
            state,
            passes: [(meter, meter_group), (adapt, adapt_group)],
        }
    }

    /// Prepares a frame `seconds` after the last one.
    pub fn prepare(&self, seconds: f32, cuts: u32) {
        let (origin, size) = self.viewport;
        let view = ExposureUniform::new(&self.settings, origin, size, seconds, cuts);
        let mut bytes = UniformBuffer::new(Vec::new());
        bytes.write(&view).expect("it fits");
        self.gpu
            .queue
            .write_buffer(&self.uniform, 0, bytes.as_ref());
        self.gpu.queue.write_buffer(&self.bevy_view, 0, &[0; 4]);
    }

    /// Dispatches the first or second pass as the crate does.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass, index: usize) {
        let (pipeline, group) = &self.passes[index];
        let groups = [workgroups(self.viewport.1), UVec2::ONE][index];
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[0, 0][..=index]);
        pass.dispatch_workgroups(groups.x, groups.y, 1);
    }

    pub fn state(&self) -> ExposureState {
        let mut state = ExposureState::default();
        StorageBuffer::new(self.gpu.read(&self.state))
            .read(&mut state)
            .expect("it has its size");
        state
    }

    /// Runs a frame and returns its state, after checking that the view received that exposure.
    pub fn frame(&self, seconds: f32, cuts: u32) -> ExposureState {
        self.prepare(seconds, cuts);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for index in 0..2 {
            self.dispatch(&mut encoder.begin_compute_pass(&Default::default()), index);
        }
        self.gpu.queue.submit([encoder.finish()]);
        let state = self.state();
        let applied = self.gpu.read(&self.bevy_view);
        let applied = f32::from_le_bytes(*applied.first_chunk().expect("it is longer"));
        assert_eq!(applied.to_bits(), state.exposure.to_bits());
        state
    }
}
