//! The passes, their bindings, and their pipelines by key.

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::render_resource::{
        BindGroupLayoutEntryBuilder, StorageTextureAccess, TextureFormat, TextureSampleType,
        binding_types::{
            storage_buffer_read_only_sized, texture_2d, texture_storage_2d, uniform_buffer,
        },
    },
};

use super::{
    binding_numbers::{
        COARSER_TEXTURE, ENTERING_TEXTURE, LAST_OUTPUT, LEVEL_OUTPUT, LIGHT_TEXTURE, NEXT_OUTPUT,
        NORMAL_TEXTURE, OUTPUT_TEXTURE, PICTURE_TEXTURE, SCATTERED_OUTPUT, SCATTERED_TEXTURE,
        TILES, VIEW,
    },
    key::SubsurfaceKey,
    uniforms::SubsurfaceUniform,
};
use crate::{
    gpu::effect_pipelines::{ComputePass, EffectPipelines},
    lighting::SUBSURFACE_LIGHT_FORMAT,
};

/// The passes, in order.
pub const PASSES: [ComputePass; 6] = [
    // Downsamples to levels 1 and 2, in the listed blocks.
    ComputePass {
        label: "lean_deferred/effects/subsurface/first",
        shader: |assets| load_embedded_asset!(assets, "down.wgsl"),
        entry: "main",
        defs: &["LISTED"],
        key_defs: &[],
        reads: &[VIEW, TILES, LIGHT_TEXTURE],
        writes: &[LEVEL_OUTPUT, NEXT_OUTPUT],
    },
    // Downsamples to levels 3, 4 and 5.
    ComputePass {
        label: "lean_deferred/effects/subsurface/down",
        shader: |assets| load_embedded_asset!(assets, "down.wgsl"),
        entry: "main",
        defs: &[],
        key_defs: &[],
        reads: &[VIEW, TILES, LIGHT_TEXTURE],
        writes: &[LEVEL_OUTPUT, NEXT_OUTPUT, LAST_OUTPUT],
    },
    // Downsamples to levels 6 and 7, and scatters back to level 5.
    ComputePass {
        label: "lean_deferred/effects/subsurface/turn",
        shader: |assets| load_embedded_asset!(assets, "turn.wgsl"),
        entry: "main",
        defs: &[],
        key_defs: &["DRAWN_OUT"],
        reads: &[VIEW, TILES, LIGHT_TEXTURE, NORMAL_TEXTURE, ENTERING_TEXTURE],
        writes: &[SCATTERED_OUTPUT],
    },
    // Scatters to level 3.
    ComputePass {
        label: "lean_deferred/effects/subsurface/up",
        shader: |assets| load_embedded_asset!(assets, "up.wgsl"),
        entry: "main",
        defs: &["UNPACKED"],
        key_defs: &["DRAWN_OUT"],
        reads: &UP_READS,
        writes: &[SCATTERED_OUTPUT],
    },
    // Scatters to level 1, in the listed blocks.
    ComputePass {
        label: "lean_deferred/effects/subsurface/up",
        shader: |assets| load_embedded_asset!(assets, "up.wgsl"),
        entry: "main",
        defs: &["UNPACKED", "LISTED"],
        key_defs: &["DRAWN_OUT"],
        reads: &UP_READS,
        writes: &[SCATTERED_OUTPUT],
    },
    // Scatters to the picture, in the listed blocks.
    ComputePass {
        label: "lean_deferred/effects/subsurface/picture",
        shader: |assets| load_embedded_asset!(assets, "picture.wgsl"),
        entry: "main",
        defs: &["PICTURE", "UNPACKED"],
        key_defs: &[],
        reads: &[
            VIEW,
            TILES,
            LIGHT_TEXTURE,
            SCATTERED_TEXTURE,
            PICTURE_TEXTURE,
        ],
        writes: &[OUTPUT_TEXTURE],
    },
];

const UP_READS: [u32; 7] = [
    VIEW,
    TILES,
    LIGHT_TEXTURE,
    SCATTERED_TEXTURE,
    COARSER_TEXTURE,
    NORMAL_TEXTURE,
    ENTERING_TEXTURE,
];

pub(super) type SubsurfacePipelines = EffectPipelines<SubsurfaceKey>;

pub(super) fn init_subsurface_pipelines(mut commands: Commands, asset_server: Res<AssetServer>) {
    commands.insert_resource(SubsurfacePipelines::new(
        &asset_server,
        &PASSES,
        binding_kind,
    ));
}

/// The kind of a binding.
fn binding_kind(binding: u32) -> Option<BindGroupLayoutEntryBuilder> {
    let words = texture_2d(TextureSampleType::Uint);
    let stored = |format| texture_storage_2d(format, StorageTextureAccess::WriteOnly);
    Some(match binding {
        VIEW => uniform_buffer::<SubsurfaceUniform>(true),
        TILES => storage_buffer_read_only_sized(false, None),
        LIGHT_TEXTURE | SCATTERED_TEXTURE | COARSER_TEXTURE => words,
        NORMAL_TEXTURE | ENTERING_TEXTURE | PICTURE_TEXTURE => words,
        LEVEL_OUTPUT | NEXT_OUTPUT | LAST_OUTPUT | SCATTERED_OUTPUT => {
            stored(SUBSURFACE_LIGHT_FORMAT)
        }
        OUTPUT_TEXTURE => stored(TextureFormat::Rgba16Float),
        _ => return None,
    })
}
