//! The passes, their bindings, and their pipelines by key.

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::render_resource::{
        BindGroupLayoutEntryBuilder, StorageTextureAccess, TextureFormat, TextureSampleType,
        binding_types::{texture_2d, texture_depth_2d, texture_storage_2d, uniform_buffer},
    },
};

use super::{
    binding_numbers::{
        DEPTH_TEXTURE, DIFFUSE_LIGHT_OUTPUT, DIFFUSE_LIGHT_TEXTURE, GATHERED_OUTPUT,
        GATHERED_TEXTURE, LAST_LEVELS, LEVEL_0, LEVEL_1, LEVEL_2, LEVEL_3, LEVELS, MOTION_TEXTURE,
        NORMAL_TEXTURE, OUTPUT_TEXTURE, PICTURE_TEXTURE, SHOWN_EXPOSURE, VIEW,
    },
    key::GiKey,
    uniforms::GiUniform,
};
use crate::{
    effects::shown_exposure::ShownExposure,
    gpu::effect_pipelines::{ComputePass, EffectPipelines},
};

/// Format of the depth and light of texels: two words each.
pub(super) const LEVELS_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// Format of light, with the occluded part of the hemisphere in alpha.
pub(super) const LIGHT_FORMAT: TextureFormat = TextureFormat::Rgba16Float;
/// Number of levels. Any device has at least four storage textures per compute shader.
pub(super) const LEVEL_COUNT: u32 = 4;

/// The passes between G-buffer and lighting, in order.
pub const PASSES: [ComputePass; 3] = [
    ComputePass {
        label: "lean_deferred/effects/diffuse_gi/levels",
        shader: |assets| load_embedded_asset!(assets, "levels.wgsl"),
        entry: "main",
        defs: &[],
        key_defs: &[],
        reads: &[
            VIEW,
            DEPTH_TEXTURE,
            DIFFUSE_LIGHT_TEXTURE,
            MOTION_TEXTURE,
            SHOWN_EXPOSURE,
            LAST_LEVELS,
        ],
        writes: &[LEVEL_0, LEVEL_1, LEVEL_2, LEVEL_3],
    },
    ComputePass {
        label: "lean_deferred/effects/diffuse_gi/gather",
        shader: |assets| load_embedded_asset!(assets, "gather.wgsl"),
        entry: "main",
        defs: &[],
        key_defs: &[
            "SLICES",
            "STEPS",
            "PROJECTION_PERSPECTIVE",
            "PROJECTION_ORTHOGRAPHIC",
        ],
        reads: &[VIEW, DEPTH_TEXTURE, NORMAL_TEXTURE, LEVELS],
        writes: &[GATHERED_OUTPUT],
    },
    ComputePass {
        label: "lean_deferred/effects/diffuse_gi/filter",
        shader: |assets| load_embedded_asset!(assets, "filter.wgsl"),
        entry: "main",
        defs: &[],
        key_defs: &[],
        reads: &[VIEW, LEVELS, GATHERED_TEXTURE],
        writes: &[OUTPUT_TEXTURE],
    },
];

pub(super) type GiPipelines = EffectPipelines<GiKey>;

pub(super) fn init_gi_pipelines(mut commands: Commands, asset_server: Res<AssetServer>) {
    commands.insert_resource(GiPipelines::new(&asset_server, &PASSES, binding_kind));
}

/// The kind of a binding.
pub(super) fn binding_kind(binding: u32) -> Option<BindGroupLayoutEntryBuilder> {
    let words = texture_2d(TextureSampleType::Uint);
    let floats = texture_2d(TextureSampleType::Float { filterable: false });
    let stored = |format| texture_storage_2d(format, StorageTextureAccess::WriteOnly);
    Some(match binding {
        VIEW => uniform_buffer::<GiUniform>(true),
        DEPTH_TEXTURE => texture_depth_2d(),
        NORMAL_TEXTURE | DIFFUSE_LIGHT_TEXTURE | LAST_LEVELS | LEVELS => words,
        MOTION_TEXTURE | GATHERED_TEXTURE | PICTURE_TEXTURE => floats,
        SHOWN_EXPOSURE => ShownExposure::layout(),
        LEVEL_0..=LEVEL_3 => stored(LEVELS_FORMAT),
        GATHERED_OUTPUT | OUTPUT_TEXTURE => stored(LIGHT_FORMAT),
        DIFFUSE_LIGHT_OUTPUT => stored(TextureFormat::R32Uint),
        _ => return None,
    })
}
