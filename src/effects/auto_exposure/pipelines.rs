//! Layouts and pipelines of the two passes.

use bevy::{
    asset::load_embedded_asset,
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_resource::{
            BindGroupLayoutDescriptor, BindGroupLayoutEntryBuilder, CachedComputePipelineId,
            ComputePipelineDescriptor, PipelineCache, SamplerBindingType, ShaderStages, ShaderType,
            TextureSampleType,
            binding_types::{sampler, storage_buffer_sized, texture_2d, uniform_buffer},
        },
        view::ViewUniform,
    },
    shader::CachedPipelineId,
};

use super::{
    binding_numbers::{BEVY_VIEW, MASK, MASK_SAMPLER, PARTIALS, PICTURE, STATE, VIEW},
    key::ExposureKey,
    uniforms::{ExposureState, ExposureUniform},
};
use crate::gpu::{bind_group_cache::ResolvedLayout, bindings::layout};

/// Pipelines of the two passes.
#[derive(Clone, Copy)]
pub(super) struct PassPipelines {
    pub(super) meter: CachedComputePipelineId,
    pub(super) adapt: CachedComputePipelineId,
}

impl PassPipelines {
    pub(super) fn are_compiled(self, pipeline_cache: &PipelineCache) -> bool {
        [self.meter, self.adapt]
            .into_iter()
            .all(|id| pipeline_cache.get_compute_pipeline(id).is_some())
    }

    pub(super) fn ids(self) -> [CachedPipelineId; 2] {
        [self.meter, self.adapt].map(|pipeline| pipeline.id())
    }
}

/// Pipelines by key. Created by `init_exposure_pipelines`.
#[derive(Resource)]
pub(super) struct ExposurePipelines {
    meter_shader: Handle<Shader>,
    adapt_shader: Handle<Shader>,
    by_key: HashMap<ExposureKey, (PassPipelines, ResolvedLayout)>,
    pub(super) adapt_layout: ResolvedLayout,
}

pub(super) fn init_exposure_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    pipeline_cache: Res<PipelineCache>,
) {
    commands.insert_resource(ExposurePipelines {
        meter_shader: load_embedded_asset!(asset_server.as_ref(), "meter.wgsl"),
        adapt_shader: load_embedded_asset!(asset_server.as_ref(), "adapt.wgsl"),
        by_key: HashMap::default(),
        adapt_layout: ResolvedLayout::new(&pipeline_cache, adapt_layout()),
    });
}

/// Layout of the first pass: settings, image, sums; with a mask also the mask and its sampler.
pub fn meter_layout(key: ExposureKey) -> BindGroupLayoutDescriptor {
    let picture = texture_2d(TextureSampleType::Float { filterable: false });
    layout(
        "lean_deferred/effects/auto_exposure/meter",
        ShaderStages::COMPUTE,
        [
            (VIEW, uniform_buffer::<ExposureUniform>(true)),
            (PICTURE, picture),
            (PARTIALS, storage_buffer_sized(false, None)),
        ]
        .into_iter()
        .chain(mask_entries(key)),
    )
}

/// Layout of the second pass: settings, sums, state, Bevy's view.
pub fn adapt_layout() -> BindGroupLayoutDescriptor {
    layout(
        "lean_deferred/effects/auto_exposure/adapt",
        ShaderStages::COMPUTE,
        [
            (VIEW, uniform_buffer::<ExposureUniform>(true)),
            (PARTIALS, storage_buffer_sized(false, None)),
            (
                STATE,
                storage_buffer_sized(false, Some(ExposureState::min_size())),
            ),
            (
                BEVY_VIEW,
                storage_buffer_sized(true, Some(ViewUniform::min_size())),
            ),
        ],
    )
}

/// Entries of the mask and its sampler, if `key` has a mask.
pub(super) fn mask_entries(
    key: ExposureKey,
) -> impl Iterator<Item = (u32, BindGroupLayoutEntryBuilder)> {
    let mask = texture_2d(TextureSampleType::Float { filterable: true });
    [
        (MASK, mask),
        (MASK_SAMPLER, sampler(SamplerBindingType::Filtering)),
    ]
    .into_iter()
    .filter(move |_| key.has_mask())
}

impl ExposurePipelines {
    /// Layout of the first pass; `None` before [`get`](Self::get) was called for `key`.
    pub(super) fn meter_layout(&self, key: ExposureKey) -> Option<&ResolvedLayout> {
        let (_, layout) = self.by_key.get(&key)?;
        Some(layout)
    }

    /// Pipelines of both passes; they may still be compiling.
    pub(super) fn get(
        &mut self,
        key: ExposureKey,
        pipeline_cache: &PipelineCache,
    ) -> PassPipelines {
        let Self {
            meter_shader,
            adapt_shader,
            by_key,
            adapt_layout,
        } = self;
        let queue = |label: &'static str,
                     found: &ResolvedLayout,
                     shader: &Handle<Shader>,
                     entry: &'static str| {
            pipeline_cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some(label.into()),
                layout: vec![found.descriptor().clone()],
                shader: shader.clone(),
                shader_defs: key.shader_defs(),
                entry_point: Some(entry.into()),
                ..default()
            })
        };
        let (passes, _) = by_key.entry(key).or_insert_with(|| {
            let found = ResolvedLayout::new(pipeline_cache, meter_layout(key));
            let meter = queue(
                "lean_deferred/effects/auto_exposure/meter",
                &found,
                meter_shader,
                "meter",
            );
            let adapt = queue(
                "lean_deferred/effects/auto_exposure/adapt",
                adapt_layout,
                adapt_shader,
                "sum_and_adapt",
            );
            (PassPipelines { meter, adapt }, found)
        });
        *passes
    }
}
