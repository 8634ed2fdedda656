//! The passes, their bindings, and their pipelines by key.

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::{
        render_resource::{
            BindGroupLayoutDescriptor, BindGroupLayoutEntryBuilder, SamplerBindingType, ShaderType,
            TextureSampleType,
            binding_types::{sampler, storage_buffer_sized, texture_2d, uniform_buffer},
        },
        view::ViewUniform,
    },
};

use super::{
    binding_numbers::{BEVY_VIEW, MASK, MASK_SAMPLER, PARTIALS, PICTURE, STATE, VIEW},
    key::ExposureKey,
    uniforms::{ExposureState, ExposureUniform},
};
use crate::gpu::effect_pipelines::{ComputePass, EffectPipelines};

/// The passes, in order.
pub const PASSES: [ComputePass; 2] = [
    ComputePass {
        label: "lean_deferred/effects/auto_exposure/meter",
        shader: |assets| load_embedded_asset!(assets, "meter.wgsl"),
        entry: "meter",
        defs: &[],
        key_defs: &[
            "LOG_AVERAGE",
            "LOG_OF_PRODUCTS",
            "WEIGHTED",
            "CENTER_WEIGHTED",
            "SPOT",
            "MASK",
            "HISTOGRAM",
            "SUBGROUPS",
        ],
        reads: &[VIEW, PICTURE, MASK, MASK_SAMPLER],
        writes: &[PARTIALS],
    },
    ComputePass {
        label: "lean_deferred/effects/auto_exposure/adapt",
        shader: |assets| load_embedded_asset!(assets, "adapt.wgsl"),
        entry: "sum_and_adapt",
        defs: &[],
        key_defs: &["LOG_AVERAGE", "HISTOGRAM", "SUBGROUPS"],
        reads: &[VIEW, PARTIALS],
        writes: &[STATE, BEVY_VIEW],
    },
];

pub(super) type ExposurePipelines = EffectPipelines<ExposureKey>;

pub(super) fn init_exposure_pipelines(mut commands: Commands, asset_server: Res<AssetServer>) {
    commands.insert_resource(ExposurePipelines::new(&asset_server, &PASSES, binding_kind));
}

/// The kind of a binding of the passes.
pub(super) fn binding_kind(binding: u32) -> Option<BindGroupLayoutEntryBuilder> {
    let floats = |filterable| texture_2d(TextureSampleType::Float { filterable });
    Some(match binding {
        VIEW => uniform_buffer::<ExposureUniform>(true),
        PICTURE => floats(false),
        PARTIALS => storage_buffer_sized(false, None),
        MASK => floats(true),
        MASK_SAMPLER => sampler(SamplerBindingType::Filtering),
        STATE => storage_buffer_sized(false, Some(ExposureState::min_size())),
        BEVY_VIEW => storage_buffer_sized(true, Some(ViewUniform::min_size())),
        _ => return None,
    })
}

/// Layouts of the passes.
pub fn layouts() -> [BindGroupLayoutDescriptor; 2] {
    PASSES.map(|pass| pass.layout(binding_kind))
}
