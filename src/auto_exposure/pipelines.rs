//! Layouts and pipelines of the two passes.

use bevy::{
    asset::load_embedded_asset,
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_asset::RenderAssets,
        render_resource::{
            BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedComputePipelineId,
            ComputePipelineDescriptor, DynamicBindGroupLayoutEntries, PipelineCache,
            SamplerBindingType, ShaderStages, ShaderType, TextureSampleType,
            binding_types::{sampler, storage_buffer_sized, texture_2d, uniform_buffer},
        },
        sync_world::MainEntity,
        texture::GpuImage,
        view::ViewUniform,
    },
};

use super::{
    ExposureKey, LeanAutoExposure, MeteringPattern,
    support::ExposureSupport,
    uniforms::{ExposureState, ExposureView},
};
use crate::warn_once::WarnOnce;

/// On a view with auto exposure: its pipelines, which may still be compiling.
#[derive(Component, Clone, Copy)]
pub struct ViewExposurePipelines {
    pub(super) key: ExposureKey,
    pub(super) meter: CachedComputePipelineId,
    pub(super) adapt: CachedComputePipelineId,
}

/// The pipelines by key. Made by `init_exposure_pipelines`.
#[derive(Resource)]
pub(super) struct ExposurePipelines {
    meter_shader: Handle<Shader>,
    adapt_shader: Handle<Shader>,
    by_key: HashMap<ExposureKey, ViewExposurePipelines>,
}

pub(super) fn init_exposure_pipelines(mut commands: Commands, asset_server: Res<AssetServer>) {
    commands.insert_resource(ExposurePipelines {
        meter_shader: load_embedded_asset!(asset_server.as_ref(), "meter.wgsl"),
        adapt_shader: load_embedded_asset!(asset_server.as_ref(), "adapt.wgsl"),
        by_key: HashMap::default(),
    });
}

/// The layout of the first pass: settings, picture, sums; mask and its sampler.
pub fn meter_layout(key: ExposureKey) -> BindGroupLayoutDescriptor {
    let entries = DynamicBindGroupLayoutEntries::sequential(
        ShaderStages::COMPUTE,
        (
            uniform_buffer::<ExposureView>(true),
            texture_2d(TextureSampleType::Float { filterable: false }),
            storage_buffer_sized(false, None),
        ),
    );
    let entries = if key.has_mask() {
        entries.extend_sequential((
            texture_2d(TextureSampleType::Float { filterable: true }),
            sampler(SamplerBindingType::Filtering),
        ))
    } else {
        entries
    };
    BindGroupLayoutDescriptor::new("lean_deferred/exposure/meter", &entries)
}

/// The layout of the second pass: settings, Bevy's view, sums, state.
pub fn adapt_layout() -> BindGroupLayoutDescriptor {
    BindGroupLayoutDescriptor::new(
        "lean_deferred/exposure/adapt",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                uniform_buffer::<ExposureView>(true),
                storage_buffer_sized(true, Some(ViewUniform::min_size())),
                storage_buffer_sized(false, None),
                storage_buffer_sized(false, Some(ExposureState::min_size())),
            ),
        ),
    )
}

/// Why cameras are without.
#[derive(Resource)]
pub(super) struct Warnings(WarnOnce<&'static str>);

impl Default for Warnings {
    fn default() -> Self {
        Self(WarnOnce::new("LeanAutoExposure"))
    }
}

/// Inserts or removes [`ViewExposurePipelines`]. A view keeps the pipelines that it has until those of new settings are
/// compiled: without any, the picture would flash.
pub(super) fn queue_exposure_pipelines(
    mut commands: Commands,
    support: Res<ExposureSupport>,
    pipelines: Option<ResMut<ExposurePipelines>>,
    mut warnings: ResMut<Warnings>,
    pipeline_cache: Res<PipelineCache>,
    images: Res<RenderAssets<GpuImage>>,
    views: Query<(
        Entity,
        &MainEntity,
        &ExtractedCamera,
        &LeanAutoExposure,
        Option<&ViewExposurePipelines>,
    )>,
    cameras: Query<&MainEntity, With<LeanAutoExposure>>,
) {
    warnings.0.keep_only(cameras.iter());
    let Some(mut pipelines) = pipelines.filter(|_| support.missing.is_none()) else {
        return;
    };
    for (entity, camera, extracted, settings, current) in &views {
        let reason = (!extracted.hdr).then_some("it has no Hdr component");
        warnings.0.tell(*camera, reason);
        if reason.is_some() {
            commands.entity(entity).remove::<ViewExposurePipelines>();
            continue;
        }
        let mask_is_loaded = match &settings.pattern {
            MeteringPattern::Mask(mask) => images.get(mask).is_some(),
            _ => false,
        };
        let subgroups = support.uses_subgroups(settings);
        let key = ExposureKey::new(settings, subgroups, mask_is_loaded);
        let view = pipelines.get(key, &pipeline_cache);
        let is_ready = [view.meter, view.adapt]
            .into_iter()
            .all(|id| pipeline_cache.get_compute_pipeline(id).is_some());
        if current.is_none() || is_ready {
            commands.entity(entity).insert(view);
        }
    }
}

impl ExposurePipelines {
    fn get(&mut self, key: ExposureKey, pipeline_cache: &PipelineCache) -> ViewExposurePipelines {
        let Self {
            meter_shader,
            adapt_shader,
            by_key,
        } = self;
        let queue = |label: &'static str, layout, shader: &Handle<Shader>, entry: &'static str| {
            pipeline_cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some(label.into()),
                layout: vec![layout],
                shader: shader.clone(),
                shader_defs: key.shader_defs(),
                entry_point: Some(entry.into()),
                ..default()
            })
        };
        *by_key.entry(key).or_insert_with(|| ViewExposurePipelines {
            key,
            meter: queue(
                "lean_deferred/exposure/meter",
                meter_layout(key),
                meter_shader,
                "meter",
            ),
            adapt: queue(
                "lean_deferred/exposure/adapt",
                adapt_layout(),
                adapt_shader,
                "sum_and_adapt",
            ),
        })
    }
}
