//! Layouts and pipelines.

use std::sync::OnceLock;

use bevy::{
    asset::load_embedded_asset,
    platform::collections::HashMap,
    prelude::*,
    render::render_resource::{
        BindGroupLayoutEntryBuilder, CachedComputePipelineId, ComputePipelineDescriptor,
        PipelineCache, ShaderStages, StorageTextureAccess, TextureFormat, TextureSampleType,
        binding_types::{
            storage_buffer_read_only_sized, texture_2d, texture_storage_2d, uniform_buffer,
        },
    },
    shader::{CachedPipelineId, ShaderDefVal},
};

use super::{
    binding_numbers::{
        COARSER_TEXTURE, ENTERING_TEXTURE, LAST_OUTPUT, LEVEL_OUTPUT, LIGHT_TEXTURE, NEXT_OUTPUT,
        NORMAL_TEXTURE, OUTPUT_TEXTURE, PICTURE_TEXTURE, SCATTERED_TEXTURE, TILES, VIEW,
    },
    key::SubsurfaceKey,
    uniforms::SubsurfaceUniform,
};
use crate::{
    gpu::{bind_group_cache::ResolvedLayout, bindings::layout},
    lighting::SUBSURFACE_LIGHT_FORMAT,
};

/// Pipelines of one key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SubsurfacePasses {
    /// Downsamples to levels 1 and 2, in the listed blocks.
    pub(super) first: CachedComputePipelineId,
    /// Downsamples to levels 3, 4 and 5.
    pub(super) down: CachedComputePipelineId,
    /// Downsamples to levels 6 and 7, and scatters back to level 5.
    pub(super) turn: CachedComputePipelineId,
    /// Scatters to level 3.
    pub(super) up: CachedComputePipelineId,
    /// Scatters to level 1, in the listed blocks.
    pub(super) last: CachedComputePipelineId,
    /// Scatters to the image, in the listed blocks.
    pub(super) picture: CachedComputePipelineId,
}

impl SubsurfacePasses {
    fn each(self) -> [CachedComputePipelineId; 6] {
        [
            self.first,
            self.down,
            self.turn,
            self.up,
            self.last,
            self.picture,
        ]
    }

    pub(super) fn are_compiled(self, cache: &PipelineCache) -> bool {
        self.each()
            .into_iter()
            .all(|pipeline| cache.get_compute_pipeline(pipeline).is_some())
    }

    pub(super) fn ids(self) -> [CachedPipelineId; 6] {
        self.each().map(|pipeline| pipeline.id())
    }
}

/// Layouts of the passes.
pub(super) struct SubsurfaceLayouts {
    pub(super) first: ResolvedLayout,
    pub(super) down: ResolvedLayout,
    pub(super) turn: ResolvedLayout,
    /// Shared by the two passes that scatter across two levels.
    pub(super) up: ResolvedLayout,
    pub(super) picture: ResolvedLayout,
}

/// Pipelines by key, and their layouts, created when the first view needs them.
#[derive(Resource)]
pub(super) struct SubsurfacePipelines {
    down: Handle<Shader>,
    turn: Handle<Shader>,
    up: Handle<Shader>,
    picture: Handle<Shader>,
    layouts: OnceLock<SubsurfaceLayouts>,
    by_key: HashMap<SubsurfaceKey, SubsurfacePasses>,
}

pub(super) fn init_subsurface_pipelines(mut commands: Commands, asset_server: Res<AssetServer>) {
    let assets = asset_server.as_ref();
    commands.insert_resource(SubsurfacePipelines {
        down: load_embedded_asset!(assets, "down.wgsl"),
        turn: load_embedded_asset!(assets, "turn.wgsl"),
        up: load_embedded_asset!(assets, "up.wgsl"),
        picture: load_embedded_asset!(assets, "picture.wgsl"),
        layouts: OnceLock::new(),
        by_key: HashMap::default(),
    });
}

impl SubsurfaceLayouts {
    fn new(cache: &PipelineCache) -> Self {
        let words = || texture_2d(TextureSampleType::Uint);
        let stored = |format| texture_storage_2d(format, StorageTextureAccess::WriteOnly);
        let found = |label: &'static str, entries: &[(u32, BindGroupLayoutEntryBuilder)]| {
            let layout = layout(label, ShaderStages::COMPUTE, entries.iter().copied());
            ResolvedLayout::new(cache, layout)
        };
        let view = (VIEW, uniform_buffer::<SubsurfaceUniform>(true));
        let tiles = (TILES, storage_buffer_read_only_sized(false, None));
        let light = (LIGHT_TEXTURE, words());
        let level = (LEVEL_OUTPUT, stored(SUBSURFACE_LIGHT_FORMAT));
        let next = (NEXT_OUTPUT, stored(SUBSURFACE_LIGHT_FORMAT));
        let last = (LAST_OUTPUT, stored(SUBSURFACE_LIGHT_FORMAT));
        let coarser = (COARSER_TEXTURE, words());
        let scattered = (SCATTERED_TEXTURE, words());
        let normal = (NORMAL_TEXTURE, words());
        let entering = (ENTERING_TEXTURE, words());
        let picture = (PICTURE_TEXTURE, words());
        let output = (OUTPUT_TEXTURE, stored(TextureFormat::Rgba16Float));
        Self {
            first: found(
                "lean_deferred/effects/subsurface/first",
                &[view, tiles, light, level, next],
            ),
            down: found(
                "lean_deferred/effects/subsurface/down",
                &[view, tiles, light, level, next, last],
            ),
            turn: found(
                "lean_deferred/effects/subsurface/turn",
                &[view, tiles, light, level, normal, entering],
            ),
            up: found(
                "lean_deferred/effects/subsurface/up",
                &[
                    view, tiles, light, scattered, coarser, level, normal, entering,
                ],
            ),
            picture: found(
                "lean_deferred/effects/subsurface/picture",
                &[view, tiles, light, scattered, picture, output],
            ),
        }
    }
}

impl SubsurfacePipelines {
    /// `None` until a view has needed pipelines.
    pub(super) fn layouts(&self) -> Option<&SubsurfaceLayouts> {
        self.layouts.get()
    }

    /// Pipelines for `key`; they may still be compiling.
    pub(super) fn specialize(
        &mut self,
        cache: &PipelineCache,
        key: SubsurfaceKey,
    ) -> SubsurfacePasses {
        if let Some(passes) = self.by_key.get(&key) {
            return *passes;
        }
        let layouts = self.layouts.get_or_init(|| SubsurfaceLayouts::new(cache));
        let queue = |shader: &Handle<Shader>, layout: &ResolvedLayout, more: &[&'static str]| {
            let more = more.iter().copied().map(ShaderDefVal::from);
            cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some(layout.descriptor().label.clone()),
                layout: vec![layout.descriptor().clone()],
                shader: shader.clone(),
                shader_defs: key.shader_defs().into_iter().chain(more).collect(),
                entry_point: Some("main".into()),
                ..default()
            })
        };
        let drawn_out = key.drawn_out();
        let passes = SubsurfacePasses {
            first: queue(&self.down, &layouts.first, &["LISTED"]),
            down: queue(&self.down, &layouts.down, &[]),
            turn: queue(&self.turn, &layouts.turn, drawn_out),
            up: queue(&self.up, &layouts.up, &[&["UNPACKED"], drawn_out].concat()),
            last: queue(
                &self.up,
                &layouts.up,
                &[&["UNPACKED", "LISTED"], drawn_out].concat(),
            ),
            picture: queue(&self.picture, &layouts.picture, &["PICTURE", "UNPACKED"]),
        };
        self.by_key.insert(key, passes);
        passes
    }
}
