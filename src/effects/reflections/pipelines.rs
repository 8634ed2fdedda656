//! The passes, their bindings, and their pipelines by key.

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::render_resource::{
        BindGroupLayoutEntryBuilder, SamplerBindingType, StorageTextureAccess, TextureFormat,
        TextureSampleType,
        binding_types::{
            sampler, texture_2d, texture_depth_2d, texture_storage_2d, uniform_buffer,
        },
    },
};

use super::{
    binding_numbers::{
        DEPTH_SAMPLER, DEPTH_TEXTURE, FILTERED_OUTPUT, FILTERED_TEXTURE, HI_Z_OUTPUT, HI_Z_TEXTURE,
        HISTORY_SAMPLER, HISTORY_TEXTURE, HITS_OUTPUT, HITS_TEXTURE, LOBES_OUTPUT, LOBES_TEXTURE,
        MOTION_TEXTURE, NORMAL_TEXTURE, OUTPUT_TEXTURE, RAYS_OUTPUT, RAYS_TEXTURE,
        SPECIALIZATION_TEXTURE, SURFACES_OUTPUT, SURFACES_TEXTURE, VALID_MASK_TEXTURE, VIEW,
    },
    key::ReflectionKey,
    uniforms::ReflectionUniform,
};
use crate::gpu::effect_pipelines::{ComputePass, EffectPipelines};

/// Format of the nearest and furthest depth, packed in a word.
pub(super) const HI_Z_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// Format of light and confidence.
pub(super) const LIGHT_FORMAT: TextureFormat = TextureFormat::Rgba16Float;
/// Format of the surfaces that send rays.
pub(super) const SURFACES_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// Format of the rays' hits.
pub(super) const HITS_FORMAT: TextureFormat = TextureFormat::R32Uint;

/// Format of the lobes of the last frames.
pub(super) const LOBES_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;

/// The passes, in order.
pub const PASSES: [ComputePass; 4] = [
    ComputePass {
        label: "lean_deferred/effects/reflections/hi_z",
        shader: |assets| load_embedded_asset!(assets, "hi_z.wgsl"),
        entry: "main",
        defs: &[],
        key_defs: &["PROJECTION_ORTHOGRAPHIC"],
        reads: &[VIEW, DEPTH_TEXTURE, DEPTH_SAMPLER],
        writes: &[HI_Z_OUTPUT],
    },
    ComputePass {
        label: "lean_deferred/effects/reflections/trace",
        shader: |assets| load_embedded_asset!(assets, "trace.wgsl"),
        entry: "main",
        defs: &[],
        key_defs: &["PROJECTION_PERSPECTIVE", "PROJECTION_ORTHOGRAPHIC"],
        reads: &[
            VIEW,
            DEPTH_TEXTURE,
            NORMAL_TEXTURE,
            VALID_MASK_TEXTURE,
            SPECIALIZATION_TEXTURE,
            MOTION_TEXTURE,
            HISTORY_TEXTURE,
            HISTORY_SAMPLER,
            HI_Z_TEXTURE,
        ],
        writes: &[SURFACES_OUTPUT, RAYS_OUTPUT, HITS_OUTPUT],
    },
    ComputePass {
        label: "lean_deferred/effects/reflections/spatial_filter",
        shader: |assets| load_embedded_asset!(assets, "spatial_filter.wgsl"),
        entry: "main",
        defs: &["SPATIAL_FILTER"],
        key_defs: &["PROJECTION_PERSPECTIVE", "PROJECTION_ORTHOGRAPHIC"],
        reads: &[
            VIEW,
            MOTION_TEXTURE,
            HISTORY_TEXTURE,
            SURFACES_TEXTURE,
            RAYS_TEXTURE,
            HITS_TEXTURE,
            LOBES_TEXTURE,
        ],
        writes: &[FILTERED_OUTPUT, LOBES_OUTPUT],
    },
    ComputePass {
        label: "lean_deferred/effects/reflections/resolve",
        shader: |assets| load_embedded_asset!(assets, "resolve.wgsl"),
        entry: "main",
        defs: &[],
        key_defs: &[
            "DIVISOR",
            "PROJECTION_PERSPECTIVE",
            "PROJECTION_ORTHOGRAPHIC",
        ],
        reads: &[
            VIEW,
            DEPTH_TEXTURE,
            NORMAL_TEXTURE,
            VALID_MASK_TEXTURE,
            SPECIALIZATION_TEXTURE,
            MOTION_TEXTURE,
            HISTORY_TEXTURE,
            HISTORY_SAMPLER,
            SURFACES_TEXTURE,
            RAYS_TEXTURE,
            HITS_TEXTURE,
            FILTERED_TEXTURE,
        ],
        writes: &[OUTPUT_TEXTURE],
    },
];

pub(super) type ReflectionPipelines = EffectPipelines<ReflectionKey>;

pub(super) fn init_reflection_pipelines(mut commands: Commands, asset_server: Res<AssetServer>) {
    commands.insert_resource(ReflectionPipelines::new(
        &asset_server,
        &PASSES,
        binding_kind,
    ));
}

/// The kind of a binding.
fn binding_kind(binding: u32) -> Option<BindGroupLayoutEntryBuilder> {
    let words = texture_2d(TextureSampleType::Uint);
    let floats = |filterable| texture_2d(TextureSampleType::Float { filterable });
    let stored = |format| texture_storage_2d(format, StorageTextureAccess::WriteOnly);
    Some(match binding {
        VIEW => uniform_buffer::<ReflectionUniform>(true),
        DEPTH_TEXTURE => texture_depth_2d(),
        DEPTH_SAMPLER => sampler(SamplerBindingType::NonFiltering),
        NORMAL_TEXTURE | VALID_MASK_TEXTURE | SPECIALIZATION_TEXTURE => words,
        MOTION_TEXTURE => floats(false),
        HISTORY_TEXTURE => floats(true),
        HISTORY_SAMPLER => sampler(SamplerBindingType::Filtering),
        HI_Z_TEXTURE | SURFACES_TEXTURE | HITS_TEXTURE | LOBES_TEXTURE => words,
        HI_Z_OUTPUT => stored(HI_Z_FORMAT),
        SURFACES_OUTPUT => stored(SURFACES_FORMAT),
        HITS_OUTPUT => stored(HITS_FORMAT),
        LOBES_OUTPUT => stored(LOBES_FORMAT),
        RAYS_TEXTURE | FILTERED_TEXTURE => floats(false),
        RAYS_OUTPUT | FILTERED_OUTPUT | OUTPUT_TEXTURE => stored(LIGHT_FORMAT),
        _ => return None,
    })
}
