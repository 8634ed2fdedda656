//! Layouts and pipelines.

use std::sync::OnceLock;

use bevy::{
    asset::load_embedded_asset,
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_resource::{
            BindGroupLayoutEntryBuilder, CachedComputePipelineId, ComputePipelineDescriptor,
            FilterMode, MipmapFilterMode, PipelineCache, Sampler, SamplerBindingType,
            SamplerDescriptor, ShaderStages, StorageTextureAccess, Texture, TextureDescriptor,
            TextureDimension, TextureFormat, TextureSampleType, TextureUsages, TextureView,
            binding_types::{
                sampler, texture_2d, texture_depth_2d, texture_storage_2d, uniform_buffer,
            },
        },
        renderer::RenderDevice,
    },
    shader::{CachedPipelineId, ShaderDefVal},
};

use super::{
    binding_numbers::{
        DEPTH_SAMPLER, DEPTH_TEXTURE, FILTERED_OUTPUT, FILTERED_TEXTURE, HI_Z_OUTPUT, HI_Z_TEXTURE,
        HISTORY_SAMPLER, HISTORY_TEXTURE, HITS_OUTPUT, HITS_TEXTURE, MOTION_TEXTURE,
        NORMAL_TEXTURE, OUTPUT_TEXTURE, RAYS_OUTPUT, RAYS_TEXTURE, SPECIALIZATION_TEXTURE,
        SURFACES_OUTPUT, SURFACES_TEXTURE, VALID_MASK_TEXTURE, VIEW,
    },
    key::ReflectionKey,
    pass::PASSES,
    uniforms::ReflectionUniform,
};
use crate::gpu::{bind_group_cache::ResolvedLayout, bindings::layout};

/// Format of the nearest and furthest depth, packed in a word.
pub(super) const HI_Z_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// Format of light and confidence.
pub(super) const LIGHT_FORMAT: TextureFormat = TextureFormat::Rgba16Float;
/// Format of the surfaces that send rays.
pub(super) const SURFACES_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// Format of the rays' hits.
pub(super) const HITS_FORMAT: TextureFormat = TextureFormat::R32Uint;

/// Shader defs of each pass, in addition to those of the key.
const DEFS: [&[&str]; PASSES.len()] = [&[], &[], &["SPATIAL_FILTER"], &[]];

/// Pipelines of one key, in the order of the passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ReflectionPasses(pub(super) [CachedComputePipelineId; PASSES.len()]);

impl ReflectionPasses {
    pub(super) fn are_compiled(self, cache: &PipelineCache) -> bool {
        self.0
            .into_iter()
            .all(|pipeline| cache.get_compute_pipeline(pipeline).is_some())
    }

    pub(super) fn ids(self) -> [CachedPipelineId; PASSES.len()] {
        self.0.map(|pipeline| pipeline.id())
    }
}

/// Layouts of the passes, in order.
pub(super) struct ReflectionLayouts(pub(super) [ResolvedLayout; PASSES.len()]);

/// Resources shared by all views.
pub(super) struct Fixtures {
    pub(super) history_sampler: Sampler,
    pub(super) depth_sampler: Sampler,
    /// A texel of 0: no special surface.
    pub(super) nothing: TextureView,
}

/// Pipelines by key, their layouts and fixtures, created when the first view needs them.
#[derive(Resource)]
pub(super) struct ReflectionPipelines {
    shaders: [Handle<Shader>; PASSES.len()],
    /// By [`ReflectionKey::specialization`].
    layouts: HashMap<bool, ReflectionLayouts>,
    fixtures: OnceLock<Fixtures>,
    by_key: HashMap<ReflectionKey, ReflectionPasses>,
}

pub(super) fn init_reflection_pipelines(mut commands: Commands, asset_server: Res<AssetServer>) {
    commands.insert_resource(ReflectionPipelines {
        shaders: [
            load_embedded_asset!(asset_server.as_ref(), "hi_z.wgsl"),
            load_embedded_asset!(asset_server.as_ref(), "trace.wgsl"),
            load_embedded_asset!(asset_server.as_ref(), "spatial_filter.wgsl"),
            load_embedded_asset!(asset_server.as_ref(), "resolve.wgsl"),
        ],
        layouts: HashMap::default(),
        fixtures: OnceLock::new(),
        by_key: HashMap::default(),
    });
}

impl Fixtures {
    fn new(device: &RenderDevice) -> Self {
        let nothing: Texture = device.create_texture(&TextureDescriptor {
            label: Some("lean_deferred/effects/reflections/nothing"),
            size: default(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: TextureFormat::R32Uint,
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        Self {
            history_sampler: device.create_sampler(&SamplerDescriptor {
                label: Some("lean_deferred/effects/reflections/history"),
                mag_filter: FilterMode::Linear,
                min_filter: FilterMode::Linear,
                mipmap_filter: MipmapFilterMode::Linear,
                ..default()
            }),
            depth_sampler: device.create_sampler(&SamplerDescriptor {
                label: Some("lean_deferred/effects/reflections/depth"),
                ..default()
            }),
            nothing: nothing.create_view(&default()),
        }
    }
}

fn layouts(cache: &PipelineCache, special: bool) -> ReflectionLayouts {
    let words = || texture_2d(TextureSampleType::Uint);
    let floats = || texture_2d(TextureSampleType::Float { filterable: false });
    let filtered = || texture_2d(TextureSampleType::Float { filterable: true });
    let stored = |format| texture_storage_2d(format, StorageTextureAccess::WriteOnly);
    let view = (VIEW, uniform_buffer::<ReflectionUniform>(true));
    let depth = (DEPTH_TEXTURE, texture_depth_2d());
    // Entries of passes that read the G-buffer and the last frame's light.
    let scene: Vec<_> = [
        depth,
        (NORMAL_TEXTURE, words()),
        (HISTORY_TEXTURE, filtered()),
        (HISTORY_SAMPLER, sampler(SamplerBindingType::Filtering)),
        (MOTION_TEXTURE, floats()),
    ]
    .into_iter()
    .chain(special.then(|| (VALID_MASK_TEXTURE, words())))
    .chain(special.then(|| (SPECIALIZATION_TEXTURE, words())))
    .collect();
    // Output of the rays.
    let texels = [
        (SURFACES_TEXTURE, words()),
        (RAYS_TEXTURE, floats()),
        (HITS_TEXTURE, words()),
    ];
    let found = |label: &'static str, parts: &[&[(u32, BindGroupLayoutEntryBuilder)]]| {
        let entries = parts.iter().copied().flatten().copied();
        let entries = [view].into_iter().chain(entries);
        ResolvedLayout::new(cache, layout(label, ShaderStages::COMPUTE, entries))
    };
    ReflectionLayouts([
        found(
            "lean_deferred/effects/reflections/hi_z",
            &[&[
                depth,
                (HI_Z_OUTPUT, stored(HI_Z_FORMAT)),
                (DEPTH_SAMPLER, sampler(SamplerBindingType::NonFiltering)),
            ]],
        ),
        found(
            "lean_deferred/effects/reflections/trace",
            &[
                &scene,
                &[
                    (HI_Z_TEXTURE, words()),
                    (SURFACES_OUTPUT, stored(SURFACES_FORMAT)),
                    (RAYS_OUTPUT, stored(LIGHT_FORMAT)),
                    (HITS_OUTPUT, stored(HITS_FORMAT)),
                ],
            ],
        ),
        found(
            "lean_deferred/effects/reflections/spatial_filter",
            &[&texels, &[(FILTERED_OUTPUT, stored(LIGHT_FORMAT))]],
        ),
        found(
            "lean_deferred/effects/reflections/resolve",
            &[
                &scene,
                &texels,
                &[
                    (FILTERED_TEXTURE, floats()),
                    (OUTPUT_TEXTURE, stored(LIGHT_FORMAT)),
                ],
            ],
        ),
    ])
}

impl ReflectionPipelines {
    pub(super) fn fixtures(&self, device: &RenderDevice) -> &Fixtures {
        self.fixtures.get_or_init(|| Fixtures::new(device))
    }

    /// Layouts of a key that has been specialized.
    pub(super) fn layouts(&self, key: ReflectionKey) -> Option<&ReflectionLayouts> {
        self.layouts.get(&key.specialization)
    }

    /// Pipelines for `key`; they may still be compiling.
    pub(super) fn specialize(
        &mut self,
        cache: &PipelineCache,
        key: ReflectionKey,
    ) -> ReflectionPasses {
        if let Some(passes) = self.by_key.get(&key) {
            return *passes;
        }
        let layouts = self
            .layouts
            .entry(key.specialization)
            .or_insert_with(|| layouts(cache, key.specialization));
        let passes = ReflectionPasses(core::array::from_fn(|pass| {
            let layout = layouts.0[pass].descriptor();
            let more = DEFS[pass].iter().copied().map(ShaderDefVal::from);
            cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some(layout.label.clone()),
                layout: vec![layout.clone()],
                shader: self.shaders[pass].clone(),
                shader_defs: key.shader_defs().into_iter().chain(more).collect(),
                entry_point: Some("main".into()),
                ..default()
            })
        }));
        self.by_key.insert(key, passes);
        passes
    }
}
