//! The dispatches, their bindings, and their pipelines.

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
        COLOR_TEXTURE, DEPTH_TEXTURE, LEVEL_0, LEVEL_1, LEVEL_2, LEVEL_3, SHOWN_EXPOSURE, VIEW,
    },
    uniforms::HistoryUniform,
};
use crate::{
    effects::shown_exposure::ShownExposure,
    gpu::effect_pipelines::{ComputePass, EffectKey, EffectPipelines},
};

/// Format of light and distance.
pub(super) const FORMAT: TextureFormat = TextureFormat::Rgba16Float;
/// Levels stored by each dispatch. Any device has at least four storage textures per compute shader.
pub(super) const LEVELS: [u32; 2] = [4, 3];

/// The dispatches, in order.
pub(super) const PASSES: [ComputePass; 2] = [
    ComputePass {
        label: "lean_deferred/effects/history",
        shader: |assets| load_embedded_asset!(assets, "levels.wgsl"),
        entry: "main",
        defs: &[],
        key_defs: &[],
        reads: &[COLOR_TEXTURE, VIEW, DEPTH_TEXTURE, SHOWN_EXPOSURE],
        writes: &[LEVEL_0, LEVEL_1, LEVEL_2, LEVEL_3],
    },
    ComputePass {
        label: "lean_deferred/effects/history/means",
        shader: |assets| load_embedded_asset!(assets, "levels.wgsl"),
        entry: "main",
        defs: &["OF_LEVEL"],
        key_defs: &[],
        reads: &[COLOR_TEXTURE],
        writes: &[LEVEL_0, LEVEL_1, LEVEL_2],
    },
];

/// The dispatches are compiled in one way, once an effect reads a history.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::effects) struct HistoryKey;

impl EffectKey for HistoryKey {}

pub(in crate::effects) type HistoryPipelines = EffectPipelines<HistoryKey>;

pub(super) fn init_history_pipelines(mut commands: Commands, asset_server: Res<AssetServer>) {
    commands.insert_resource(HistoryPipelines::new(&asset_server, &PASSES, binding_kind));
}

fn binding_kind(binding: u32) -> Option<BindGroupLayoutEntryBuilder> {
    Some(match binding {
        COLOR_TEXTURE => texture_2d(TextureSampleType::Float { filterable: false }),
        LEVEL_0..=LEVEL_3 => texture_storage_2d(FORMAT, StorageTextureAccess::WriteOnly),
        VIEW => uniform_buffer::<HistoryUniform>(true),
        DEPTH_TEXTURE => texture_depth_2d(),
        SHOWN_EXPOSURE => ShownExposure::layout(),
        _ => return None,
    })
}
