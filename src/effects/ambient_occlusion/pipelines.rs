//! Layouts and pipelines: the gather as a compute or a raster pass, and the merge.

use core::iter;

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::FullscreenShader,
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_resource::{
            BindGroupLayoutDescriptor, BindGroupLayoutEntryBuilder, BlendComponent, BlendFactor,
            BlendOperation, BlendState, CachedComputePipelineId, CachedRenderPipelineId,
            ColorTargetState, ColorWrites, ComputePipelineDescriptor, FilterMode, FragmentState,
            PipelineCache, RenderPipelineDescriptor, Sampler, SamplerBindingType,
            SamplerDescriptor, ShaderStages, StorageTextureAccess, TextureSampleType,
            binding_types::{
                sampler, texture_2d, texture_depth_2d, texture_storage_2d, uniform_buffer,
            },
        },
        renderer::RenderDevice,
    },
    shader::CachedPipelineId,
};

use super::{
    binding_numbers::{
        DEPTH_TEXTURE, NEAREST_SAMPLER, NORMAL_TEXTURE, OCCLUSION_TEXTURE, OUTPUT_TEXTURE,
        SPARSE_DEPTH_OUTPUT, SPARSE_DEPTH_TEXTURE, VIEW,
    },
    key::{GatherKey, MergeKey},
    support::{FORMAT, SPARSE_DEPTH_FORMAT},
    uniforms::OcclusionUniform,
};
use crate::gpu::{
    bind_group_cache::ResolvedLayout, bindings::layout, pipeline_watch::PipelineWatch,
};

/// `dst · (1 - occlusion)`; alpha is unchanged.
const MULTIPLICATIVE: BlendState = BlendState {
    color: BlendComponent {
        src_factor: BlendFactor::Zero,
        dst_factor: BlendFactor::OneMinusSrc,
        operation: BlendOperation::Add,
    },
    alpha: BlendComponent {
        src_factor: BlendFactor::Zero,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    },
};

/// Pipeline of the gather.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GatherPipeline {
    Compute {
        gather: CachedComputePipelineId,
        /// Of the pass before it, for kernels that read sparse depth.
        sparse_depth: Option<CachedComputePipelineId>,
    },
    Raster(CachedRenderPipelineId),
}

impl GatherPipeline {
    pub(super) fn is_compiled(self, cache: &PipelineCache) -> bool {
        match self {
            Self::Compute {
                gather,
                sparse_depth,
            } => iter::once(gather)
                .chain(sparse_depth)
                .all(|pipeline| cache.get_compute_pipeline(pipeline).is_some()),
            Self::Raster(pipeline) => cache.get_render_pipeline(pipeline).is_some(),
        }
    }

    pub(super) fn ids(self) -> impl Iterator<Item = CachedPipelineId> {
        let (first, second) = match self {
            Self::Compute {
                gather,
                sparse_depth,
            } => (gather.id(), sparse_depth.map(|pipeline| pipeline.id())),
            Self::Raster(pipeline) => (pipeline.id(), None),
        };
        iter::once(first).chain(second)
    }
}

/// Pipelines by key. Created by `init_occlusion_pipelines`.
#[derive(Resource)]
pub(super) struct OcclusionPipelines {
    sparse_depth_shader: Handle<Shader>,
    gather_shader: Handle<Shader>,
    merge_shader: Handle<Shader>,
    fullscreen: FullscreenShader,
    pub(super) nearest_sampler: Sampler,
    pub(super) sparse_depth_layout: ResolvedLayout,
    pub(super) merge_layout: ResolvedLayout,
    sparse_depth: Option<CachedComputePipelineId>,
    gathers: HashMap<GatherKey, (GatherPipeline, ResolvedLayout)>,
    merges: HashMap<MergeKey, CachedRenderPipelineId>,
}

pub(super) fn init_occlusion_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    render_device: Res<RenderDevice>,
    fullscreen: Res<FullscreenShader>,
    pipeline_cache: Res<PipelineCache>,
) {
    commands.insert_resource(OcclusionPipelines {
        sparse_depth_shader: load_embedded_asset!(asset_server.as_ref(), "sparse_depth.wgsl"),
        gather_shader: load_embedded_asset!(asset_server.as_ref(), "gather.wgsl"),
        merge_shader: load_embedded_asset!(asset_server.as_ref(), "merge.wgsl"),
        fullscreen: fullscreen.clone(),
        nearest_sampler: render_device.create_sampler(&SamplerDescriptor {
            label: Some("lean_deferred/effects/ambient_occlusion/nearest"),
            mag_filter: FilterMode::Nearest,
            min_filter: FilterMode::Nearest,
            ..default()
        }),
        sparse_depth_layout: ResolvedLayout::new(&pipeline_cache, sparse_depth_layout()),
        sparse_depth: None,
        merge_layout: ResolvedLayout::new(
            &pipeline_cache,
            filter_layout("lean_deferred/effects/ambient_occlusion/merge"),
        ),
        gathers: HashMap::default(),
        merges: HashMap::default(),
    });
}

/// The layout of passes that filter the occlusion: the merge, and the debug view.
pub(super) fn filter_layout(label: &'static str) -> BindGroupLayoutDescriptor {
    let occlusion = texture_2d(TextureSampleType::Float { filterable: false });
    layout(
        label,
        ShaderStages::FRAGMENT,
        common_entries()
            .into_iter()
            .chain([(OCCLUSION_TEXTURE, occlusion)]),
    )
}

fn sparse_depth_layout() -> BindGroupLayoutDescriptor {
    let output = texture_storage_2d(SPARSE_DEPTH_FORMAT, StorageTextureAccess::WriteOnly);
    layout(
        "lean_deferred/effects/ambient_occlusion/sparse_depth",
        ShaderStages::COMPUTE,
        [
            (VIEW, uniform_buffer::<OcclusionUniform>(true)),
            (DEPTH_TEXTURE, texture_depth_2d()),
            (SPARSE_DEPTH_OUTPUT, output),
        ],
    )
}

fn gather_layout(key: GatherKey) -> BindGroupLayoutDescriptor {
    let stages = if key.computes {
        ShaderStages::COMPUTE
    } else {
        ShaderStages::FRAGMENT
    };
    let normals = (NORMAL_TEXTURE, texture_2d(TextureSampleType::Uint));
    let output = (
        OUTPUT_TEXTURE,
        texture_storage_2d(FORMAT, StorageTextureAccess::WriteOnly),
    );
    let sparse_depth = (
        SPARSE_DEPTH_TEXTURE,
        texture_2d(TextureSampleType::Float { filterable: false }),
    );
    layout(
        "lean_deferred/effects/ambient_occlusion/gather",
        stages,
        common_entries()
            .into_iter()
            .chain(key.shading_normals.then_some(normals))
            .chain(key.computes.then_some(output))
            .chain(key.reads_sparse_depth().then_some(sparse_depth)),
    )
}

/// Entries that both passes bind.
fn common_entries() -> [(u32, BindGroupLayoutEntryBuilder); 3] {
    [
        (VIEW, uniform_buffer::<OcclusionUniform>(true)),
        (DEPTH_TEXTURE, texture_depth_2d()),
        (NEAREST_SAMPLER, sampler(SamplerBindingType::NonFiltering)),
    ]
}

impl OcclusionPipelines {
    /// Layout of the gather's only bind group; `None` before [`gather`](Self::gather) was called for `key`.
    pub(super) fn gather_layout(&self, key: GatherKey) -> Option<&ResolvedLayout> {
        let (_, layout) = self.gathers.get(&key)?;
        Some(layout)
    }

    /// All gathers that were asked for; they may still be compiling.
    pub(super) fn gathers(&self) -> impl Iterator<Item = (GatherKey, GatherPipeline)> {
        self.gathers
            .iter()
            .map(|(key, (gather, _))| (*key, *gather))
    }

    /// Pipeline of the gather if [`gather`](Self::gather) was called for `key`.
    pub(super) fn asked_gather(&self, key: GatherKey) -> Option<GatherPipeline> {
        let (pipeline, _) = self.gathers.get(&key)?;
        Some(*pipeline)
    }

    /// Pipeline of the gather; it may still be compiling. `None` if it is withheld.
    pub(super) fn gather(
        &mut self,
        pipeline_cache: &PipelineCache,
        watch: &PipelineWatch,
        key: GatherKey,
    ) -> Option<GatherPipeline> {
        if let Some(pipeline) = self.asked_gather(key) {
            return Some(pipeline);
        }
        if !watch.budget.admits() {
            return None;
        }
        let label = Some("lean_deferred/effects/ambient_occlusion/gather".into());
        let found = ResolvedLayout::new(pipeline_cache, gather_layout(key));
        let layouts = vec![found.descriptor().clone()];
        let shader_defs = key.shader_defs();
        let shader = self.gather_shader.clone();
        let pipeline = if key.computes {
            let sparse_depth = key.reads_sparse_depth().then(|| {
                *self.sparse_depth.get_or_insert_with(|| {
                    pipeline_cache.queue_compute_pipeline(ComputePipelineDescriptor {
                        label: Some("lean_deferred/effects/ambient_occlusion/sparse_depth".into()),
                        layout: vec![self.sparse_depth_layout.descriptor().clone()],
                        shader: self.sparse_depth_shader.clone(),
                        entry_point: Some("compute".into()),
                        ..default()
                    })
                })
            });
            let gather = pipeline_cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label,
                layout: layouts,
                shader,
                shader_defs,
                entry_point: Some("compute".into()),
                ..default()
            });
            GatherPipeline::Compute {
                gather,
                sparse_depth,
            }
        } else {
            GatherPipeline::Raster(
                pipeline_cache.queue_render_pipeline(RenderPipelineDescriptor {
                    label,
                    layout: layouts,
                    vertex: self.fullscreen.to_vertex_state(),
                    fragment: Some(FragmentState {
                        shader,
                        shader_defs,
                        entry_point: Some("fragment".into()),
                        targets: vec![Some(FORMAT.into())],
                    }),
                    ..default()
                }),
            )
        };
        self.gathers.insert(key, (pipeline, found));
        Some(pipeline)
    }

    /// Pipeline that blends the occlusion into the image; it may still be compiling. `None` if it is withheld.
    pub(super) fn merge(
        &mut self,
        pipeline_cache: &PipelineCache,
        watch: &PipelineWatch,
        key: MergeKey,
    ) -> Option<CachedRenderPipelineId> {
        if let Some(pipeline) = self.merges.get(&key) {
            return Some(*pipeline);
        }
        if !watch.budget.admits() {
            return None;
        }
        let pipeline = pipeline_cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some("lean_deferred/effects/ambient_occlusion/merge".into()),
            layout: vec![self.merge_layout.descriptor().clone()],
            vertex: self.fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: self.merge_shader.clone(),
                shader_defs: key.shader_defs(),
                entry_point: Some("fragment".into()),
                targets: vec![Some(ColorTargetState {
                    format: key.target,
                    blend: Some(MULTIPLICATIVE),
                    write_mask: ColorWrites::ALL,
                })],
            }),
            ..default()
        });
        self.merges.insert(key, pipeline);
        Some(pipeline)
    }
}
