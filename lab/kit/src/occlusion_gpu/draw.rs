//! Draws over a texture, and the bindings of such draws.

use bevy::math::UVec2;
use bevy_lean_deferred::effects::ambient_occlusion::binding_numbers as numbers;

use super::OcclusionGpu;
use crate::wgsl::Definitions;

const FULLSCREEN: &str = r"
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
";

pub(super) enum Target<'a> {
    Color(&'a wgpu::TextureView, wgpu::TextureFormat),
    Depth(&'a wgpu::TextureView),
}

impl OcclusionGpu {
    pub(super) fn layout(
        &self,
        stage: wgpu::ShaderStages,
        output: Option<(u32, wgpu::TextureFormat)>,
        sampled: &[u32],
    ) -> wgpu::BindGroupLayout {
        use wgpu::BindingType as Type;
        let mut entries = vec![
            layout_entry(
                numbers::VIEW,
                stage,
                Type::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            ),
            layout_entry(
                numbers::DEPTH_TEXTURE,
                stage,
                Type::Texture {
                    sample_type: wgpu::TextureSampleType::Depth,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            ),
            layout_entry(
                numbers::NEAREST_SAMPLER,
                stage,
                Type::Sampler(wgpu::SamplerBindingType::NonFiltering),
            ),
        ];
        entries.extend((sampled.iter()).map(|at| layout_entry(*at, stage, float_texture())));
        if let Some((binding, format)) = output {
            entries.push(layout_entry(
                binding,
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

    pub(super) fn group(
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

    pub(super) fn compute(
        &self,
        layout: &wgpu::BindGroupLayout,
        source: &str,
        definitions: Definitions,
    ) -> wgpu::ComputePipeline {
        (self.device).create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: Some(&self.pipeline_layout(layout)),
            module: &self.shader(source, definitions),
            entry_point: Some("compute"),
            compilation_options: Default::default(),
            cache: None,
        })
    }

    pub(super) fn pipeline_layout(&self, layout: &wgpu::BindGroupLayout) -> wgpu::PipelineLayout {
        self.device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(layout)],
                immediate_size: 0,
            })
    }

    /// Draws one triangle over the target, or over a part of it.
    pub(super) fn draw(
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
        let vertex = self.shader(FULLSCREEN, Definitions::new());
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
}

pub(super) fn layout_entry(
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

pub(super) fn float_texture() -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}
