//! Runs the shipped gather and merge shaders of ambient occlusion on the device, over depth buffers made on the CPU.

use std::{borrow::Cow, collections::HashMap, sync::Mutex};

use bevy::{
    math::{Mat4, UVec2},
    render::render_resource::encase::UniformBuffer,
};
use bevy_lean_deferred::ambient_occlusion::{
    LeanAmbientOcclusion, OcclusionFormat, OcclusionKernel, OcclusionQuality, OcclusionResolution,
    OcclusionView, ProjectionKind, projection_of,
};
use half::f16;
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};

use super::gpu;

/// The modules that `gather.wgsl` and `merge.wgsl` import, in the order of their own imports.
const MODULES: [(&str, &str); 10] = [
    (
        "layout.wgsl",
        include_str!("../../src/shader_library/layout.wgsl"),
    ),
    (
        "tiles.wgsl",
        include_str!("../../src/shader_library/tiles.wgsl"),
    ),
    (
        "position.wgsl",
        include_str!("../../src/shader_library/reconstruction/position.wgsl"),
    ),
    (
        "normal.wgsl",
        include_str!("../../src/shader_library/reconstruction/normal.wgsl"),
    ),
    (
        "view.wgsl",
        include_str!("../../src/ambient_occlusion/view.wgsl"),
    ),
    (
        "horizon.wgsl",
        include_str!("../../src/ambient_occlusion/horizon.wgsl"),
    ),
    (
        "bindings.wgsl",
        include_str!("../../src/ambient_occlusion/bindings.wgsl"),
    ),
    (
        "hbao.wgsl",
        include_str!("../../src/ambient_occlusion/hbao.wgsl"),
    ),
    (
        "hdao.wgsl",
        include_str!("../../src/ambient_occlusion/hdao.wgsl"),
    ),
    (
        "filter.wgsl",
        include_str!("../../src/ambient_occlusion/filter.wgsl"),
    ),
];
const GATHER: &str = include_str!("../../src/ambient_occlusion/gather.wgsl");
const MERGE: &str = include_str!("../../src/ambient_occlusion/merge.wgsl");

/// Draws a depth buffer: copies into one are not allowed.
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
const FULLSCREEN: &str = r"
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
";

/// A depth buffer and how it was seen.
pub struct DepthImage {
    pub depth: Vec<f32>,
    pub size: UVec2,
    pub clip_from_view: Mat4,
    /// Where the view lies in the buffer; all of it unless told otherwise.
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
    /// As stored: of the viewport, or half its size.
    pub gathered: Vec<f32>,
    /// After the filter and `intensity`: of the viewport.
    pub filtered: Vec<f32>,
}

/// Which of the gather's two entry points runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    Compute,
    Raster,
}

/// A device of its own.
pub struct OcclusionGpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    nearest: wgpu::Sampler,
    /// By source and definitions: composing takes longer than running.
    shaders: Mutex<HashMap<(&'static str, Vec<String>), wgpu::ShaderModule>>,
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

    pub fn run(&self, settings: &LeanAmbientOcclusion, image: &DepthImage) -> Occlusion {
        self.run_by(Path::Compute, settings, image)
    }

    pub fn run_by(
        &self,
        path: Path,
        settings: &LeanAmbientOcclusion,
        image: &DepthImage,
    ) -> Occlusion {
        let depth = self.depth_texture(image);
        let (origin, size) = image.viewport;
        let mut view = OcclusionView::new(settings, image.clip_from_view, size);
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

        let format = settings.format.texture_format();
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
                binding: 0,
                resource: uniform.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::TextureView(&depth_view),
            },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::Sampler(&self.nearest),
            },
        ];
        let mut defs = gather_definitions(settings, image.clip_from_view);
        match path {
            Path::Compute => {
                defs.insert("COMPUTE".into(), ShaderDefValue::Bool(true));
                let layout = self.layout(wgpu::ShaderStages::COMPUTE, Some(format), false);
                let mut entries = common.to_vec();
                entries.push(wgpu::BindGroupEntry {
                    binding: 4,
                    resource: wgpu::BindingResource::TextureView(&stored_view),
                });
                let group = self.group(&layout, &entries);
                let pipeline =
                    self.device
                        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                            label: None,
                            layout: Some(&self.pipeline_layout(&layout)),
                            module: &self.shader(GATHER, defs),
                            entry_point: Some("compute"),
                            compilation_options: Default::default(),
                            cache: None,
                        });
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &group, &[]);
                let tiles = view.texture_size.map(|n| n.div_ceil(16));
                pass.dispatch_workgroups(tiles.x, tiles.y, 1);
            }
            Path::Raster => {
                let layout = self.layout(wgpu::ShaderStages::FRAGMENT, None, false);
                let group = self.group(&layout, &common);
                self.draw(
                    &mut encoder,
                    (&layout, &group),
                    self.shader(GATHER, defs),
                    Target::Color(&stored_view, format),
                    None,
                );
            }
        }

        // The merge's debug view shows what is left of the light.
        let shown = self.texture(
            image.size,
            wgpu::TextureFormat::R32Float,
            Usage::RENDER_ATTACHMENT | Usage::COPY_SRC,
        );
        let layout = self.layout(wgpu::ShaderStages::FRAGMENT, None, true);
        let mut entries = common.to_vec();
        entries.push(wgpu::BindGroupEntry {
            binding: 3,
            resource: wgpu::BindingResource::TextureView(&stored_view),
        });
        let group = self.group(&layout, &entries);
        self.draw(
            &mut encoder,
            (&layout, &group),
            self.shader(MERGE, filter_definitions(settings)),
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

    /// What the shaders read of an image's depths: drivers clamp what is drawn to a depth buffer.
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
            self.shader(DEPTH_READER, HashMap::new()),
            target,
            None,
        );
        self.queue.submit([encoder.finish()]);
        self.read(&copy)
    }

    fn texture(
        &self,
        size: UVec2,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        gpu::texture(&self.device, size, format, usage)
    }

    fn depth_texture(&self, image: &DepthImage) -> wgpu::Texture {
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
            self.shader(DEPTH_WRITER, HashMap::new()),
            Target::Depth(&depth.create_view(&Default::default())),
            None,
        );
        self.queue.submit([encoder.finish()]);
        depth
    }

    fn layout(
        &self,
        stage: wgpu::ShaderStages,
        output: Option<wgpu::TextureFormat>,
        reads_occlusion: bool,
    ) -> wgpu::BindGroupLayout {
        use wgpu::BindingType as Type;
        let mut entries = vec![
            layout_entry(
                0,
                stage,
                Type::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            ),
            layout_entry(
                1,
                stage,
                Type::Texture {
                    sample_type: wgpu::TextureSampleType::Depth,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            ),
            layout_entry(
                2,
                stage,
                Type::Sampler(wgpu::SamplerBindingType::NonFiltering),
            ),
        ];
        if reads_occlusion {
            entries.push(layout_entry(3, stage, float_texture()));
        }
        if let Some(format) = output {
            entries.push(layout_entry(
                4,
                stage,
                Type::StorageTexture {
                    access: wgpu::StorageTextureAccess::WriteOnly,
                    format,
                    view_dimension: wgpu::TextureViewDimension::D2,
                },
            ));
        }
        self.device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &entries,
            })
    }

    fn group(
        &self,
        layout: &wgpu::BindGroupLayout,
        entries: &[wgpu::BindGroupEntry],
    ) -> wgpu::BindGroup {
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries,
        })
    }

    fn pipeline_layout(&self, layout: &wgpu::BindGroupLayout) -> wgpu::PipelineLayout {
        self.device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(layout)],
                immediate_size: 0,
            })
    }

    fn shader(
        &self,
        source: &'static str,
        defs: HashMap<String, ShaderDefValue>,
    ) -> wgpu::ShaderModule {
        let mut key: Vec<String> = defs.iter().map(|def| format!("{def:?}")).collect();
        key.sort();
        let mut shaders = self.shaders.lock().expect("no test panics in here");
        let shader = shaders.entry((source, key));
        shader.or_insert_with(|| self.compose(source, defs)).clone()
    }

    fn compose(
        &self,
        source: &'static str,
        defs: HashMap<String, ShaderDefValue>,
    ) -> wgpu::ShaderModule {
        let mut composer = Composer::default();
        composer.validate = false;
        for (path, source) in MODULES {
            let added = composer
                .add_composable_module(ComposableModuleDescriptor {
                    source,
                    file_path: path,
                    ..Default::default()
                })
                .map(|_| ());
            if let Err(error) = added {
                panic!("{}", error.emit_to_string(&composer));
            }
        }
        let composed = composer.make_naga_module(NagaModuleDescriptor {
            source,
            file_path: "occlusion.wgsl",
            shader_defs: defs,
            ..Default::default()
        });
        let module = composed.unwrap_or_else(|error| panic!("{}", error.emit_to_string(&composer)));
        self.device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: None,
                source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
            })
    }

    /// One triangle over the target, or over a part of it.
    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (layout, group): (&wgpu::BindGroupLayout, &wgpu::BindGroup),
        fragment: wgpu::ShaderModule,
        target: Target,
        viewport: Option<(UVec2, UVec2)>,
    ) {
        let color_state = match target {
            Target::Color(_, format) => Some(wgpu::ColorTargetState::from(format)),
            Target::Depth(_) => None,
        };
        let vertex = self.shader(FULLSCREEN, HashMap::new());
        let pipeline = self
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: None,
                layout: Some(&self.pipeline_layout(layout)),
                vertex: wgpu::VertexState {
                    module: &vertex,
                    entry_point: None,
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: color_state.is_none().then(|| wgpu::DepthStencilState {
                    format: wgpu::TextureFormat::Depth32Float,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Always),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &fragment,
                    entry_point: None,
                    compilation_options: Default::default(),
                    targets: &color_state.map(Some).into_iter().collect::<Vec<_>>(),
                }),
                multiview_mask: None,
                cache: None,
            });
        let color = match target {
            Target::Color(view, _) => Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            }),
            Target::Depth(_) => None,
        };
        let depth = match target {
            Target::Depth(view) => Some(wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            Target::Color(..) => None,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &color.map(Some).into_iter().collect::<Vec<_>>(),
            depth_stencil_attachment: depth,
            ..Default::default()
        });
        if let Some((origin, size)) = viewport {
            let (origin, size) = (origin.as_vec2(), size.as_vec2());
            pass.set_viewport(origin.x, origin.y, size.x, size.y, 0.0, 1.0);
        }
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// The red channel.
    fn read(&self, texture: &wgpu::Texture) -> Vec<f32> {
        let size = texture.size();
        let texel = texture.format().block_copy_size(None).expect("a colour");
        let row = (size.width * texel).next_multiple_of(256);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * size.height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            size,
        );
        self.queue.submit([encoder.finish()]);
        buffer.map_async(wgpu::MapMode::Read, .., |mapped| {
            mapped.unwrap_or_else(|error| panic!("the results cannot be read: {error}"));
        });
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .unwrap_or_else(|error| panic!("the device did not finish: {error}"));
        let bytes = buffer.get_mapped_range(..);
        bytes
            .chunks(row as usize)
            .flat_map(|line| line[..(size.width * texel) as usize].chunks(texel as usize))
            .map(|texel| match *texel {
                [unorm] => f32::from(unorm) / 255.0,
                [a, b] => half(u16::from_le_bytes([a, b])),
                [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
                _ => panic!("a texel of {} bytes", texel.len()),
            })
            .collect()
    }
}

enum Target<'a> {
    Color(&'a wgpu::TextureView, wgpu::TextureFormat),
    Depth(&'a wgpu::TextureView),
}

fn layout_entry(
    binding: u32,
    visibility: wgpu::ShaderStages,
    ty: wgpu::BindingType,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty,
        count: None,
    }
}

fn float_texture() -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}

/// A half-precision number, finite and not negative, as occlusion is; any other is not a number.
pub fn half(bits: u16) -> f32 {
    let value = f16::from_bits(bits);
    if value.is_finite() && value.is_sign_positive() {
        value.to_f32()
    } else {
        f32::NAN
    }
}

/// As the crate compiles the gather for `settings`, on a camera without a G-buffer.
fn gather_definitions(
    settings: &LeanAmbientOcclusion,
    clip_from_view: Mat4,
) -> HashMap<String, ShaderDefValue> {
    let divisor = if settings.resolution == OcclusionResolution::Half {
        2
    } else {
        1
    };
    let (slices, steps) = settings.quality.samples();
    let mut values = vec![("DIVISOR", divisor)];
    if !matches!(settings.quality, OcclusionQuality::Custom { .. }) {
        values.extend([("SLICES", slices), ("STEPS", steps)]);
    }
    let mut defs: HashMap<_, _> = values
        .into_iter()
        .map(|(name, value)| (name.to_string(), ShaderDefValue::UInt(value)))
        .collect();
    let flags = [
        (settings.kernel == OcclusionKernel::Hdao, "HDAO"),
        (settings.thickness < 1.0, "THIN"),
        (settings.format == OcclusionFormat::Float16, "FLOAT16"),
        (
            projection_of(clip_from_view) == ProjectionKind::Perspective,
            "PROJECTION_PERSPECTIVE",
        ),
        (
            projection_of(clip_from_view) == ProjectionKind::Orthographic,
            "PROJECTION_ORTHOGRAPHIC",
        ),
    ];
    insert_flags(&mut defs, &flags);
    defs
}

/// As the crate compiles the filter, for its debug view.
fn filter_definitions(settings: &LeanAmbientOcclusion) -> HashMap<String, ShaderDefValue> {
    use bevy_lean_deferred::ambient_occlusion::OcclusionFilter as Filter;
    let half = settings.resolution == OcclusionResolution::Half;
    let filter = settings.filter;
    let mut defs = HashMap::new();
    let flags = [
        (true, "DEBUG_VIEW"),
        (half, "OCCLUSION_HALF"),
        (
            !half && matches!(filter, Filter::Flat | Filter::FlatEdgeAware),
            "OCCLUSION_FLAT",
        ),
        (
            matches!(filter, Filter::BinomialEdgeAware | Filter::FlatEdgeAware),
            "OCCLUSION_EDGE_AWARE",
        ),
    ];
    insert_flags(&mut defs, &flags);
    defs
}

fn insert_flags(defs: &mut HashMap<String, ShaderDefValue>, flags: &[(bool, &str)]) {
    for (condition, name) in flags {
        if *condition {
            defs.insert((*name).into(), ShaderDefValue::Bool(true));
        }
    }
}
