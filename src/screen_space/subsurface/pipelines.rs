//! Layouts and pipelines.

use bevy::{
    asset::load_embedded_asset,
    platform::collections::HashMap,
    prelude::*,
    render::render_resource::{
        BindGroupLayoutEntryBuilder, CachedComputePipelineId, ComputePipelineDescriptor,
        PipelineCache, ShaderStages, StorageTextureAccess, TextureFormat, TextureSampleType,
        binding_types::{
            storage_buffer_read_only_sized, texture_2d, texture_depth_2d, texture_storage_2d,
            uniform_buffer,
        },
    },
    shader::ShaderDefVal,
};

use super::{
    binding_numbers::{
        ACROSS_OUTPUT, ACROSS_TEXTURE, DEPTH_TEXTURE, LEVEL_0, LIGHT_TEXTURE, OUTPUT_TEXTURE,
        PICTURE_TEXTURE, TILES, VIEW,
    },
    key::{Method, SubsurfaceKey},
    uniforms::SubsurfaceView,
};
use crate::{
    gpu::{bind_group_cache::FoundLayout, bindings::layout},
    lighting::{SUBSURFACE_LEVELS, SUBSURFACE_LIGHT_FORMAT},
};

/// Of light that has scattered along rows.
pub(super) const ACROSS_FORMAT: TextureFormat = TextureFormat::R32Uint;

/// The pipelines of one key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SubsurfacePasses {
    /// What the second one reads: means of the light, or light that has scattered along rows.
    pub(super) first: CachedComputePipelineId,
    /// That which writes the picture.
    pub(super) second: CachedComputePipelineId,
    pub(super) clear: CachedComputePipelineId,
}

impl SubsurfacePasses {
    pub(super) fn are_compiled(self, cache: &PipelineCache) -> bool {
        [self.first, self.second, self.clear]
            .into_iter()
            .all(|pipeline| cache.get_compute_pipeline(pipeline).is_some())
    }
}

/// The layouts of the passes of a method.
pub(super) struct SubsurfaceLayouts {
    pub(super) first: FoundLayout,
    pub(super) second: FoundLayout,
    pub(super) clear: FoundLayout,
}

/// The pipelines by key, and their layouts: made when the first view asks for them.
#[derive(Resource)]
pub(super) struct SubsurfacePipelines {
    levels: Handle<Shader>,
    scatter: Handle<Shader>,
    separable: Handle<Shader>,
    clear: Handle<Shader>,
    /// By whether the method is the separable one.
    layouts: HashMap<bool, SubsurfaceLayouts>,
    by_key: HashMap<SubsurfaceKey, SubsurfacePasses>,
}

pub(super) fn init_subsurface_pipelines(mut commands: Commands, asset_server: Res<AssetServer>) {
    let assets = asset_server.as_ref();
    commands.insert_resource(SubsurfacePipelines {
        levels: load_embedded_asset!(assets, "levels.wgsl"),
        scatter: load_embedded_asset!(assets, "scatter.wgsl"),
        separable: load_embedded_asset!(assets, "separable.wgsl"),
        clear: load_embedded_asset!(assets, "clear.wgsl"),
        layouts: HashMap::default(),
        by_key: HashMap::default(),
    });
}

/// What is stored of the light, from the level `first` on.
fn stored_levels(first: usize) -> impl Iterator<Item = (u32, BindGroupLayoutEntryBuilder)> {
    let format = SUBSURFACE_LIGHT_FORMAT;
    (first..SUBSURFACE_LEVELS).map(move |level| {
        let stored = texture_storage_2d(format, StorageTextureAccess::WriteOnly);
        (LEVEL_0 + level as u32, stored)
    })
}

fn layouts(cache: &PipelineCache, is_separable: bool) -> SubsurfaceLayouts {
    let words = || texture_2d(TextureSampleType::Uint);
    let stored = |format| texture_storage_2d(format, StorageTextureAccess::WriteOnly);
    let found = |label: &'static str, entries: Vec<(u32, BindGroupLayoutEntryBuilder)>| {
        let always = [
            (VIEW, uniform_buffer::<SubsurfaceView>(true)),
            (TILES, storage_buffer_read_only_sized(false, None)),
        ];
        let entries = always.into_iter().chain(entries);
        FoundLayout::new(cache, layout(label, ShaderStages::COMPUTE, entries))
    };
    let surfaces = [
        (LIGHT_TEXTURE, words()),
        (PICTURE_TEXTURE, words()),
        (DEPTH_TEXTURE, texture_depth_2d()),
    ];
    let with_surfaces = |entry| surfaces.into_iter().chain(entry).collect();
    let output = (OUTPUT_TEXTURE, stored(TextureFormat::Rgba16Float));
    let (first, second) = if is_separable {
        let across = (ACROSS_OUTPUT, stored(ACROSS_FORMAT));
        (
            found(
                "lean_deferred/subsurface/across",
                with_surfaces(vec![across]),
            ),
            found(
                "lean_deferred/subsurface/down",
                with_surfaces(vec![(ACROSS_TEXTURE, words()), output]),
            ),
        )
    } else {
        let light = (LIGHT_TEXTURE, words());
        (
            found(
                "lean_deferred/subsurface/levels",
                [light].into_iter().chain(stored_levels(1)).collect(),
            ),
            found(
                "lean_deferred/subsurface/scatter",
                with_surfaces(vec![output]),
            ),
        )
    };
    SubsurfaceLayouts {
        first,
        second,
        clear: found("lean_deferred/subsurface/clear", stored_levels(0).collect()),
    }
}

impl SubsurfacePipelines {
    /// `None` before a view has asked for `key`.
    pub(super) fn layouts_of(&self, key: SubsurfaceKey) -> Option<&SubsurfaceLayouts> {
        self.layouts.get(&(key.method == Method::Separable))
    }

    /// The pipelines for `key`; they may still be compiling.
    pub(super) fn specialize(
        &mut self,
        cache: &PipelineCache,
        key: SubsurfaceKey,
    ) -> SubsurfacePasses {
        if let Some(passes) = self.by_key.get(&key) {
            return *passes;
        }
        let is_separable = key.method == Method::Separable;
        let layouts = self
            .layouts
            .entry(is_separable)
            .or_insert_with(|| layouts(cache, is_separable));
        let queue = |shader: &Handle<Shader>, layout: &FoundLayout, more: Option<&'static str>| {
            let mut shader_defs = key.shader_defs();
            shader_defs.extend(more.map(ShaderDefVal::from));
            cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some(layout.descriptor().label.clone()),
                layout: vec![layout.descriptor().clone()],
                shader: shader.clone(),
                shader_defs,
                entry_point: Some("main".into()),
                ..default()
            })
        };
        let (first, second) = if is_separable {
            (
                queue(&self.separable, &layouts.first, Some("ACROSS")),
                queue(&self.separable, &layouts.second, None),
            )
        } else {
            (
                queue(&self.levels, &layouts.first, None),
                queue(&self.scatter, &layouts.second, None),
            )
        };
        let clear = queue(&self.clear, &layouts.clear, None);
        let passes = SubsurfacePasses {
            first,
            second,
            clear,
        };
        self.by_key.insert(key, passes);
        passes
    }
}
