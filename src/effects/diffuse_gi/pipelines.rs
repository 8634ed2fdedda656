//! Layouts and pipelines.

use bevy::{
    asset::load_embedded_asset,
    platform::collections::HashMap,
    prelude::*,
    render::render_resource::{
        CachedComputePipelineId, ComputePipelineDescriptor, PipelineCache, ShaderStages,
        StorageTextureAccess, TextureFormat, TextureSampleType,
        binding_types::{texture_2d, texture_depth_2d, texture_storage_2d, uniform_buffer},
    },
    shader::CachedPipelineId,
};

use super::{
    binding_numbers::{
        DEPTH_TEXTURE, DIFFUSE_LIGHT_TEXTURE, GATHERED_TEXTURE, LAST_LEVELS, LEVEL_0, LEVELS,
        MOTION_TEXTURE, NORMAL_TEXTURE, OUTPUT_TEXTURE, SHOWN_EXPOSURE, VIEW,
    },
    key::GiKey,
    uniforms::GiUniform,
};
use crate::{
    effects::shown_exposure::ShownExposure,
    gpu::{bind_group_cache::ResolvedLayout, bindings::layout},
};

/// Format of the depth and light of texels: two words each.
pub(super) const LEVELS_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// Format of light, with the occluded part of the hemisphere in alpha.
pub(super) const LIGHT_FORMAT: TextureFormat = TextureFormat::Rgba16Float;
/// Number of levels. Any device has at least four storage textures per compute shader.
pub(super) const LEVEL_COUNT: u32 = 4;

/// Pipelines of one key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct GiPasses {
    pub(super) levels: CachedComputePipelineId,
    pub(super) gather: CachedComputePipelineId,
    pub(super) filter: CachedComputePipelineId,
}

impl GiPasses {
    fn each(self) -> [CachedComputePipelineId; 3] {
        [self.levels, self.gather, self.filter]
    }

    pub(super) fn are_compiled(self, cache: &PipelineCache) -> bool {
        self.each()
            .into_iter()
            .all(|pipeline| cache.get_compute_pipeline(pipeline).is_some())
    }

    pub(super) fn ids(self) -> [CachedPipelineId; 3] {
        self.each().map(|pipeline| pipeline.id())
    }
}

/// Pipelines by key. Created by `init_gi_pipelines`.
#[derive(Resource)]
pub(super) struct GiPipelines {
    shaders: [Handle<Shader>; 3],
    pub(super) levels_layout: ResolvedLayout,
    pub(super) gather_layout: ResolvedLayout,
    pub(super) filter_layout: ResolvedLayout,
    by_key: HashMap<GiKey, GiPasses>,
}

pub(super) fn init_gi_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    cache: Res<PipelineCache>,
) {
    let words = || texture_2d(TextureSampleType::Uint);
    let floats = || texture_2d(TextureSampleType::Float { filterable: false });
    let stored = |format| texture_storage_2d(format, StorageTextureAccess::WriteOnly);
    let view = || (VIEW, uniform_buffer::<GiUniform>(true));
    let levels_layout = layout(
        "lean_deferred/effects/diffuse_gi/levels",
        ShaderStages::COMPUTE,
        [
            view(),
            (DEPTH_TEXTURE, texture_depth_2d()),
            (DIFFUSE_LIGHT_TEXTURE, words()),
            (LAST_LEVELS, words()),
            (MOTION_TEXTURE, floats()),
            (SHOWN_EXPOSURE, ShownExposure::layout()),
        ]
        .into_iter()
        .chain((0..LEVEL_COUNT).map(|level| (LEVEL_0 + level, stored(LEVELS_FORMAT)))),
    );
    let gather_layout = layout(
        "lean_deferred/effects/diffuse_gi/gather",
        ShaderStages::COMPUTE,
        [
            view(),
            (DEPTH_TEXTURE, texture_depth_2d()),
            (NORMAL_TEXTURE, words()),
            (LEVELS, words()),
            (OUTPUT_TEXTURE, stored(LIGHT_FORMAT)),
        ],
    );
    let filter_layout = layout(
        "lean_deferred/effects/diffuse_gi/filter",
        ShaderStages::COMPUTE,
        [
            view(),
            (LEVELS, words()),
            (GATHERED_TEXTURE, floats()),
            (OUTPUT_TEXTURE, stored(LIGHT_FORMAT)),
        ],
    );
    commands.insert_resource(GiPipelines {
        shaders: [
            load_embedded_asset!(asset_server.as_ref(), "levels.wgsl"),
            load_embedded_asset!(asset_server.as_ref(), "gather.wgsl"),
            load_embedded_asset!(asset_server.as_ref(), "filter.wgsl"),
        ],
        levels_layout: ResolvedLayout::new(&cache, levels_layout),
        gather_layout: ResolvedLayout::new(&cache, gather_layout),
        filter_layout: ResolvedLayout::new(&cache, filter_layout),
        by_key: HashMap::default(),
    });
}

impl GiPipelines {
    /// Pipelines for `key`; they may still be compiling.
    pub(super) fn specialize(&mut self, cache: &PipelineCache, key: GiKey) -> GiPasses {
        if let Some(passes) = self.by_key.get(&key) {
            return *passes;
        }
        let queue = |label: &'static str, shader: &Handle<Shader>, layout: &ResolvedLayout| {
            cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some(label.into()),
                layout: vec![layout.descriptor().clone()],
                shader: shader.clone(),
                shader_defs: key.shader_defs(),
                entry_point: Some("main".into()),
                ..default()
            })
        };
        let [levels, gather, filter] = &self.shaders;
        let passes = GiPasses {
            levels: queue(
                "lean_deferred/effects/diffuse_gi/levels",
                levels,
                &self.levels_layout,
            ),
            gather: queue(
                "lean_deferred/effects/diffuse_gi/gather",
                gather,
                &self.gather_layout,
            ),
            filter: queue(
                "lean_deferred/effects/diffuse_gi/filter",
                filter,
                &self.filter_layout,
            ),
        };
        self.by_key.insert(key, passes);
        passes
    }
}
