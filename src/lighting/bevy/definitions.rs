//! The shader definitions of Bevy's mesh pipeline with which its lighting functions and the view bindings are compiled.
//!
//! They are read from Bevy instead of derived here: they depend on Bevy's features and on the platform, which only
//! Bevy's own crates see.

use alloc::sync::Arc;

use bevy::{
    mesh::{MeshVertexBufferLayout, MeshVertexBufferLayoutRef, VertexBufferLayout},
    pbr::{MeshPipeline, MeshPipelineKey},
    render::render_resource::SpecializedMeshPipeline,
    shader::ShaderDefVal,
};

use super::binding_numbers::{arrays, view};
pub use crate::gpu::shader_defs::name_of;

/// The bits of Bevy's view key for which the lighting shader is specialized. The others concern the rasterization of
/// meshes or passes after lighting, or functions that lighting does not call: `TEMPORAL_JITTER` is read by transmission
/// and SSAO alone, `VIEW_PROJECTION_*` by conversions between depth and view-space z.
pub const VIEW_BITS: MeshPipelineKey = {
    let mut bits = MeshPipelineKey::SHADOW_FILTER_METHOD_RESERVED_BITS;
    let mut i = 0;
    while i < VIEW_FLAGS.len() {
        bits = bits.union(VIEW_FLAGS[i]);
        i += 1;
    }
    bits
};

/// The flags among [`VIEW_BITS`].
pub const VIEW_FLAGS: [MeshPipelineKey; 6] = [
    MeshPipelineKey::ENVIRONMENT_MAP,
    MeshPipelineKey::IRRADIANCE_VOLUME,
    MeshPipelineKey::SCREEN_SPACE_AMBIENT_OCCLUSION,
    MeshPipelineKey::CONTACT_SHADOWS,
    MeshPipelineKey::DISTANCE_FOG,
    MeshPipelineKey::ATMOSPHERE,
];

/// Definitions for meshes and their materials, which lighting does not read.
pub const OF_MESHES: [&str; 10] = [
    "MESH_PIPELINE",
    "VERTEX_OUTPUT_INSTANCE_INDEX",
    "PBR_TRANSMISSION_TEXTURES_SUPPORTED",
    "PBR_MULTI_LAYER_MATERIAL_TEXTURES_SUPPORTED",
    "PBR_ANISOTROPY_TEXTURE_SUPPORTED",
    "PBR_SPECULAR_TEXTURES_SUPPORTED",
    "SKINS_USE_UNIFORM_BUFFERS",
    "SCREEN_SPACE_SPECULAR_TRANSMISSION_BLUR_TAPS",
    "MULTIPLE_LIGHTMAPS_IN_ARRAY",
    "PER_OBJECT_BUFFER_BATCH_SIZE",
];

/// A binding of Bevy's view layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BevyBinding {
    /// In bind group 0.
    View(u32),
    /// In bind group 1.
    Arrays(u32),
}

/// Definitions with which shaders read bindings that lighting binds for some views only, or never.
pub const OF_BINDINGS: [(&str, BevyBinding); 4] = [
    ("AREA_LIGHT_LUTS", BevyBinding::View(view::AREA_LIGHT_LUTS)),
    (
        "PCSS_SAMPLERS_AVAILABLE",
        BevyBinding::View(view::POINT_SHADOW_TEXTURES_LINEAR_SAMPLER),
    ),
    (
        "CLUSTERED_DECALS_ARE_USABLE",
        BevyBinding::Arrays(arrays::CLUSTERED_DECALS),
    ),
    (
        "LIGHT_TEXTURES",
        BevyBinding::Arrays(arrays::CLUSTERED_DECALS),
    ),
];

/// All definitions with which Bevy compiles the shaders of a mesh without vertex attributes.
pub fn of_mesh_pipeline(pipeline: &MeshPipeline, key: MeshPipelineKey) -> Vec<ShaderDefVal> {
    let no_attributes = MeshVertexBufferLayout::new(Vec::new(), VertexBufferLayout::default());
    let no_attributes = MeshVertexBufferLayoutRef(Arc::new(no_attributes));
    let descriptor = pipeline.specialize(key, &no_attributes);
    descriptor.map_or_else(|_| Vec::new(), |descriptor| descriptor.vertex.shader_defs)
}

/// Filters the definitions that lighting reads if it `binds` these bindings.
pub fn read_by_lighting(
    mut definitions: Vec<ShaderDefVal>,
    binds: impl Fn(BevyBinding) -> bool,
) -> Vec<ShaderDefVal> {
    definitions.retain(|definition| {
        let name = name_of(definition);
        let mut of_bindings = OF_BINDINGS.iter();
        !OF_MESHES.contains(&name)
            && of_bindings.all(|(other, binding)| *other != name || binds(*binding))
    });
    definitions
}
