//! Layouts and pipelines.

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::render_resource::{
        BindGroupLayoutEntryBuilder, CachedComputePipelineId, ComputePipelineDescriptor,
        PipelineCache, ShaderStages, StorageTextureAccess, TextureFormat, TextureSampleType,
        binding_types::{texture_2d, texture_depth_2d, texture_storage_2d, uniform_buffer},
    },
};

use super::{
    binding_numbers::{
        COLOR_TEXTURE, DEPTH_TEXTURE, LEVEL_0, LEVEL_1, LEVEL_2, LEVEL_3, SHOWN_EXPOSURE, VIEW,
    },
    uniforms::HistoryUniform,
};
use crate::{
    effects::shown_exposure::ShownExposure,
    gpu::{bind_group_cache::ResolvedLayout, bindings::layout},
};

/// Format of light and distance.
pub(super) const FORMAT: TextureFormat = TextureFormat::Rgba16Float;
/// Levels stored by each dispatch. Any device has at least four storage textures per compute shader.
pub(super) const LEVELS: [u32; 2] = [4, 3];

/// Pipelines of the two dispatches. Created by `init_history_pipelines`.
#[derive(Resource)]
pub(in crate::effects) struct HistoryPipelines {
    pub(super) layouts: [ResolvedLayout; 2],
    shader: Handle<Shader>,
    /// `None` until an effect reads a history.
    pub(super) queued: Option<[CachedComputePipelineId; 2]>,
}

pub(super) fn init_history_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    cache: Res<PipelineCache>,
) {
    let floats = || texture_2d(TextureSampleType::Float { filterable: false });
    let stored = || texture_storage_2d(FORMAT, StorageTextureAccess::WriteOnly);
    let level = |number: u32| -> (u32, BindGroupLayoutEntryBuilder) { (number, stored()) };
    let picture = layout(
        "lean_deferred/effects/history",
        ShaderStages::COMPUTE,
        [
            (COLOR_TEXTURE, floats()),
            level(LEVEL_0),
            level(LEVEL_1),
            level(LEVEL_2),
            level(LEVEL_3),
            (VIEW, uniform_buffer::<HistoryUniform>(true)),
            (DEPTH_TEXTURE, texture_depth_2d()),
            (SHOWN_EXPOSURE, ShownExposure::layout()),
        ],
    );
    let means = layout(
        "lean_deferred/effects/history/means",
        ShaderStages::COMPUTE,
        [
            (COLOR_TEXTURE, floats()),
            level(LEVEL_0),
            level(LEVEL_1),
            level(LEVEL_2),
        ],
    );
    let layouts = [picture, means].map(|descriptor| ResolvedLayout::new(&cache, descriptor));
    commands.insert_resource(HistoryPipelines {
        layouts,
        shader: load_embedded_asset!(asset_server.as_ref(), "levels.wgsl"),
        queued: None,
    });
}

impl HistoryPipelines {
    /// Queues the pipelines for compilation, once.
    pub(super) fn queue(&mut self, cache: &PipelineCache) {
        let (layouts, shader) = (&self.layouts, &self.shader);
        self.queued.get_or_insert_with(|| {
            core::array::from_fn(|dispatch| {
                let layout = layouts[dispatch].descriptor();
                let of_level = (dispatch == 1).then(|| "OF_LEVEL".into());
                cache.queue_compute_pipeline(ComputePipelineDescriptor {
                    label: Some(layout.label.clone()),
                    layout: vec![layout.clone()],
                    shader: shader.clone(),
                    shader_defs: of_level.into_iter().collect(),
                    entry_point: Some("main".into()),
                    ..default()
                })
            })
        });
    }
}
