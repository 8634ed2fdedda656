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
    ExposureBindings, ExposureKey, ExposureOverlay, LeanAutoExposure, MeteringPattern,
    support::ExposureSupport,
    uniforms::{ExposureState, ExposureView, ViewExposure},
};
use crate::{gpu::bind_group_cache::FoundLayout, view::warn_once::WarnOnce};

/// On a view with auto exposure: what it is metered with.
#[derive(Component, Clone)]
pub struct ViewExposurePipelines {
    pub(super) key: ExposureKey,
    /// `Some` if the key has one.
    pub(super) mask: Option<Handle<Image>>,
    pub(super) passes: PassPipelines,
}

/// Those of the two passes.
#[derive(Clone, Copy)]
pub(super) struct PassPipelines {
    pub(super) meter: CachedComputePipelineId,
    pub(super) adapt: CachedComputePipelineId,
}

impl PassPipelines {
    fn are_compiled(self, pipeline_cache: &PipelineCache) -> bool {
        [self.meter, self.adapt]
            .into_iter()
            .all(|id| pipeline_cache.get_compute_pipeline(id).is_some())
    }
}

/// The pipelines by key. Made by `init_exposure_pipelines`.
#[derive(Resource)]
pub(super) struct ExposurePipelines {
    meter_shader: Handle<Shader>,
    adapt_shader: Handle<Shader>,
    by_key: HashMap<ExposureKey, (PassPipelines, FoundLayout)>,
    pub(super) adapt_layout: FoundLayout,
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
        adapt_layout: FoundLayout::new(&pipeline_cache, adapt_layout()),
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

/// All that a view has only while it is metered.
type MeteringState = (
    ViewExposurePipelines,
    ViewExposure,
    ExposureBindings,
    ExposureOverlay,
);

/// Inserts or removes [`ViewExposurePipelines`]. A view keeps the pipelines that it has until those of new settings are
/// compiled: without any, the picture would flash. Cameras that are switched off lose them, and so what they hold on the
/// GPU, but for their history.
pub(super) fn queue_exposure_pipelines(
    mut commands: Commands,
    support: Res<ExposureSupport>,
    pipelines: Option<ResMut<ExposurePipelines>>,
    mut warnings: ResMut<Warnings>,
    pipeline_cache: Res<PipelineCache>,
    images: Res<RenderAssets<GpuImage>>,
    mut views: Query<(
        Entity,
        &MainEntity,
        &ExtractedCamera,
        &LeanAutoExposure,
        Option<&mut ViewExposurePipelines>,
    )>,
    cameras: Query<&MainEntity, With<LeanAutoExposure>>,
    switched_off: Query<Entity, (With<ViewExposurePipelines>, Without<ExtractedCamera>)>,
) {
    warnings.0.keep_only(cameras.iter());
    for entity in &switched_off {
        commands.entity(entity).remove::<MeteringState>();
    }
    let Some(mut pipelines) = pipelines.filter(|_| support.missing.is_none()) else {
        return;
    };
    for (entity, camera, extracted, settings, current) in &mut views {
        let reason = (!extracted.hdr).then_some("it has no Hdr component");
        warnings.0.tell(*camera, reason);
        if reason.is_some() {
            if current.is_some() {
                commands.entity(entity).remove::<MeteringState>();
            }
            continue;
        }
        let mask = match &settings.pattern {
            MeteringPattern::Mask(mask) if images.get(mask).is_some() => Some(mask),
            _ => None,
        };
        let subgroups = support.uses_subgroups(settings);
        let key = ExposureKey::new(settings, subgroups, mask.is_some());
        let passes = pipelines.get(key, &pipeline_cache);
        match current {
            Some(current) if current.key == key && current.mask.as_ref() == mask => {}
            Some(mut current) => {
                if passes.are_compiled(&pipeline_cache) {
                    *current = ViewExposurePipelines {
                        key,
                        mask: mask.cloned(),
                        passes,
                    };
                }
            }
            None => {
                commands.entity(entity).insert(ViewExposurePipelines {
                    key,
                    mask: mask.cloned(),
                    passes,
                });
            }
        }
    }
}

impl ExposurePipelines {
    /// The layout of the first pass, if there is a pipeline for `key`.
    pub(super) fn meter_layout(&self, key: ExposureKey) -> Option<&FoundLayout> {
        let (_, layout) = self.by_key.get(&key)?;
        Some(layout)
    }

    fn get(&mut self, key: ExposureKey, pipeline_cache: &PipelineCache) -> PassPipelines {
        let Self {
            meter_shader,
            adapt_shader,
            by_key,
            adapt_layout,
        } = self;
        let queue = |label: &'static str,
                     layout: &FoundLayout,
                     shader: &Handle<Shader>,
                     entry: &'static str| {
            pipeline_cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some(label.into()),
                layout: vec![layout.descriptor().clone()],
                shader: shader.clone(),
                shader_defs: key.shader_defs(),
                entry_point: Some(entry.into()),
                ..default()
            })
        };
        let (passes, _) = by_key.entry(key).or_insert_with(|| {
            let layout = FoundLayout::new(pipeline_cache, meter_layout(key));
            let meter = queue(
                "lean_deferred/exposure/meter",
                &layout,
                meter_shader,
                "meter",
            );
            let adapt = queue(
                "lean_deferred/exposure/adapt",
                adapt_layout,
                adapt_shader,
                "sum_and_adapt",
            );
            (PassPipelines { meter, adapt }, layout)
        });
        *passes
    }
}
