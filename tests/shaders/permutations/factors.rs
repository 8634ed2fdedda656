//! The definitions that Bevy and the crate compile shaders with. `NAME` is true, `NAME=1` an unsigned number.

use std::collections::HashSet;

use super::{covering::Factor, implied::implied_by};

/// With or without the definitions.
macro_rules! optional {
    ($($name:literal),+) => {
        &[&[], &[$($name),+]]
    };
}

/// Definitions of the lighting shader for any view: those of `lighting/definitions.rs`, and Bevy's. `definitions` adds what they imply.
pub const LIGHTING: &[Factor] = &[
    optional!("ENVIRONMENT_MAP"),
    // Irradiance volumes are not usable on the web, whatever the view has.
    &[
        &[],
        &["IRRADIANCE_VOLUMES_ARE_USABLE"],
        &["IRRADIANCE_VOLUMES_ARE_USABLE", "IRRADIANCE_VOLUME"],
    ],
    // Bevy's own ambient occlusion, and the crate's.
    optional!("SCREEN_SPACE_AMBIENT_OCCLUSION"),
    &[
        &[],
        &["LEAN_AMBIENT_OCCLUSION"],
        &["LEAN_AMBIENT_OCCLUSION", "OCCLUSION_MULTIBOUNCE"],
        &["LEAN_AMBIENT_OCCLUSION", "OCCLUSION_OF_DIRECT_LIGHT"],
        &[
            "LEAN_AMBIENT_OCCLUSION",
            "OCCLUSION_MULTIBOUNCE",
            "OCCLUSION_OF_DIRECT_LIGHT",
        ],
    ],
    OCCLUSION_FILTERS,
    optional!("CONTACT_SHADOWS"),
    optional!("DISTANCE_FOG"),
    optional!("ATMOSPHERE"),
    &[
        &["SHADOW_FILTER_METHOD_HARDWARE_2X2"],
        &["SHADOW_FILTER_METHOD_GAUSSIAN"],
        &["SHADOW_FILTER_METHOD_TEMPORAL"],
    ],
    optional!("BLUE_NOISE_TEXTURE"),
    optional!("DFG_LUT"),
    optional!("AREA_LIGHT_LUTS"),
    optional!("MULTIPLE_LIGHT_PROBES_IN_ARRAY"),
    &[
        &[],
        &["CLUSTERED_DECALS_ARE_USABLE"],
        &["CLUSTERED_DECALS_ARE_USABLE", "LIGHT_TEXTURES"],
    ],
    &[
        &[],
        &["DIRECTIONAL_SHADOW_MAPS"],
        &["DIRECTIONAL_SHADOW_MAPS", "SEVERAL_DIRECTIONAL_SHADOW_MAPS"],
        &["POINT_SHADOW_MAPS"],
        &["SPOT_SHADOW_MAPS"],
        &["POINT_SHADOW_MAPS", "SPOT_SHADOW_MAPS"],
    ],
    // Bevy's feature `experimental_pbr_pcss` provides the samplers.
    &[
        &[],
        &["SOFT_SHADOWS"],
        &["SOFT_SHADOWS", "PCSS_SAMPLERS_AVAILABLE"],
    ],
    &[
        &[],
        &["PROJECTION_PERSPECTIVE"],
        &["PROJECTION_ORTHOGRAPHIC"],
    ],
    &[
        &[],
        &["LIGHT_CULLING"],
        &["LIGHT_CULLING", "LIGHT_CULLING_BY_SUBGROUPS"],
    ],
    &[
        &[],
        &["CLUSTERED_LIGHTS"],
        &["SPOT_LIGHTS"],
        &["SPHERE_LIGHTS"],
        &["SPOT_LIGHTS", "SPHERE_LIGHTS"],
    ],
    optional!("SCATTERS_LIGHT"),
    &[
        &[],
        &["DIFFUSE_LIGHT"],
        &["INDIRECT_SPECULAR"],
        &["INDIRECT_DIFFUSE"],
        &["DIFFUSE_LIGHT", "INDIRECT_SPECULAR", "INDIRECT_DIFFUSE"],
    ],
    &[
        &[],
        &["LIGHT_LAYERS"],
        &["LIGHT_LAYERS", "GBUFFER_VISIBILITY_MASK"],
    ],
    &[
        &[],
        &["GBUFFER_EMISSIVE"],
        &["GBUFFER_SPECIALIZATION"],
        &["GBUFFER_EMISSIVE", "GBUFFER_SPECIALIZATION"],
    ],
    DEBUG_VIEWS,
    SPECIAL_SURFACES,
    optional!("LIGHTMAPPED_SURFACES"),
    optional!("SUPERSET"),
];

/// Debug views that lighting draws.
const DEBUG_VIEWS: Factor = &[
    &[],
    &["DEBUG_ALBEDO"],
    &["DEBUG_METALLIC"],
    &["DEBUG_MATERIAL_OCCLUSION"],
    &["DEBUG_NORMAL"],
    &["DEBUG_ROUGHNESS"],
    &["DEBUG_GEOMETRIC_NORMAL"],
    &["DEBUG_DEPTH"],
    &["DEBUG_EMISSIVE"],
    &["DEBUG_SHADING_MODEL"],
    &["DEBUG_MOTION"],
    &["DEBUG_MOTION", "GBUFFER_MOTION"],
    &["DEBUG_VISIBILITY_MASK"],
    &["DEBUG_VISIBILITY_MASK", "GBUFFER_VISIBILITY_MASK"],
    &["DEBUG_DIFFUSE_LIGHT"],
    &["DEBUG_SPECULAR_LIGHT"],
    &["DEBUG_FORWARD"],
];

/// A dispatch may list special surfaces, or light them.
const SPECIAL_SURFACES: Factor = &[
    &[],
    &["LISTED_VARIANTS"],
    &["VISITED_VARIANTS", "STANDARD_MATERIAL_ANISOTROPY"],
    &["VISITED_VARIANTS", "SHADING_MODEL_RIM"],
    &["VISITED_VARIANTS", "STANDARD_MATERIAL_CLEARCOAT"],
    &["VISITED_VARIANTS", "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION"],
    &[
        "VISITED_VARIANTS",
        "STANDARD_MATERIAL_ANISOTROPY",
        "SHADING_MODEL_RIM",
    ],
    &[
        "VISITED_VARIANTS",
        "STANDARD_MATERIAL_ANISOTROPY",
        "SHADING_MODEL_RIM",
        "STANDARD_MATERIAL_CLEARCOAT",
        "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION",
    ],
];

/// Definitions of `LightingIo::OCCLUSION_FILTER` for any settings of ambient occlusion.
const OCCLUSION_FILTERS: Factor = &[
    &[],
    &["OCCLUSION_EDGE_AWARE"],
    &["OCCLUSION_WIDE"],
    &["OCCLUSION_WIDE", "OCCLUSION_EDGE_AWARE"],
    &["OCCLUSION_HALF"],
    &["OCCLUSION_HALF", "OCCLUSION_EDGE_AWARE"],
];

/// Definitions of `GatherKey::shader_defs` for a view with ambient occlusion, for both kinds of pass.
pub const OCCLUSION_GATHER: &[Factor] = &[
    &[
        &["SHADING_NORMALS"],
        &["SHADING_NORMALS", "THIN"],
        &[],
        &["THIN"],
        &["HDAO"],
    ],
    optional!("COMPUTE"),
    OCCLUSION_PROJECTIONS,
];

/// Definitions with which a workgroup of ambient occlusion shares depths.
pub const SHARES_DEPTHS: [&str; 2] = ["COMPUTE", "SHARED_DEPTHS"];

/// As [`OCCLUSION_GATHER`], where depths are shared.
pub const OCCLUSION_GATHER_SHARED: &[Factor] = &[
    optional!("SHADING_NORMALS"),
    optional!("THIN"),
    OCCLUSION_PROJECTIONS,
];

const OCCLUSION_PROJECTIONS: Factor = &[
    &["PROJECTION_PERSPECTIVE"],
    &["PROJECTION_ORTHOGRAPHIC"],
    &[],
];

/// Definitions of `OcclusionPipelines::merge`.
pub const OCCLUSION_MERGE: &[Factor] = &[OCCLUSION_FILTERS];

/// Definitions of the debug view of ambient occlusion.
pub const OCCLUSION_DEBUG_VIEW: &[Factor] = &[OCCLUSION_FILTERS];

/// Definitions of Bevy's `PrepassPipeline` and `StandardMaterial` for a mesh that the G-buffer carries. (A second UV set without a first is
/// missing: Bevy's own `pbr_fragment.wgsl` does not compile with it.)
pub const GBUFFER: &[Factor] = &[
    &[
        &[],
        &["VERTEX_NORMALS"],
        &["VERTEX_UVS_A"],
        &["VERTEX_NORMALS", "VERTEX_UVS_A"],
        &["VERTEX_NORMALS", "VERTEX_UVS_A", "VERTEX_UVS_B"],
        &["VERTEX_NORMALS", "VERTEX_UVS_A", "VERTEX_TANGENTS"],
        &[
            "VERTEX_NORMALS",
            "VERTEX_UVS_A",
            "VERTEX_UVS_B",
            "VERTEX_TANGENTS",
        ],
    ],
    optional!("VERTEX_COLORS"),
    &[
        &[],
        &["SKINNED"],
        &["MORPH_TARGETS"],
        &["SKINNED", "MORPH_TARGETS"],
    ],
    optional!("SKINS_USE_UNIFORM_BUFFERS"),
    optional!("MAY_DISCARD"),
    optional!("VISIBILITY_RANGE_DITHER"),
    // Bevy sets both on devices with binding arrays, but materials may opt out of `BINDLESS`.
    &[
        &[],
        &["MULTIPLE_LIGHTMAPS_IN_ARRAY"],
        &["MULTIPLE_LIGHTMAPS_IN_ARRAY", "BINDLESS"],
    ],
    &[
        &[],
        &["MOTION_VECTOR_PREPASS", "GBUFFER_MOTION"],
        &[
            "MOTION_VECTOR_PREPASS",
            "HAS_PREVIOUS_SKIN",
            "HAS_PREVIOUS_MORPH",
            "GBUFFER_MOTION",
        ],
    ],
    optional!("GBUFFER_VISIBILITY_MASK"),
    // Meshes without optional targets may clear the valid mask.
    optional!("GBUFFER_VALID_MASK"),
    // For all projections.
    &[&["VIEW_PROJECTION_NONSTANDARD"]],
    optional!("STANDARD_MATERIAL_NORMAL_MAP"),
    optional!("RELIEF_MAPPING"),
    optional!(
        "STANDARD_MATERIAL_BASE_COLOR_UV_B",
        "STANDARD_MATERIAL_METALLIC_ROUGHNESS_UV_B",
        "STANDARD_MATERIAL_OCCLUSION_UV_B",
        "STANDARD_MATERIAL_NORMAL_MAP_UV_B"
    ),
    optional!(
        "STANDARD_MATERIAL_EMISSIVE_UV_B",
        "STANDARD_MATERIAL_SPECULAR_UV_B",
        "STANDARD_MATERIAL_SPECULAR_TINT_UV_B",
        "STANDARD_MATERIAL_CLEARCOAT_UV_B",
        "STANDARD_MATERIAL_CLEARCOAT_ROUGHNESS_UV_B",
        "STANDARD_MATERIAL_CLEARCOAT_NORMAL_UV_B",
        "STANDARD_MATERIAL_ANISOTROPY_UV_B",
        "STANDARD_MATERIAL_SPECULAR_TRANSMISSION_UV_B",
        "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION_UV_B",
        "STANDARD_MATERIAL_THICKNESS_UV_B"
    ),
    optional!("PBR_SPECULAR_TEXTURES_SUPPORTED"),
    optional!("PBR_MULTI_LAYER_MATERIAL_TEXTURES_SUPPORTED"),
    optional!("PBR_ANISOTROPY_TEXTURE_SUPPORTED"),
    optional!("PBR_TRANSMISSION_TEXTURES_SUPPORTED"),
    WHAT_IS_DRAWN,
];

/// The optional targets, and the materials and meshes that only passes with these targets draw.
const WHAT_IS_DRAWN: Factor = &[
    &[],
    &["GBUFFER_EMISSIVE"],
    &["GBUFFER_SPECIALIZATION"],
    &["GBUFFER_EMISSIVE", "GBUFFER_SPECIALIZATION"],
    &["STANDARD_MATERIAL_CLEARCOAT"],
    &["STANDARD_MATERIAL_CLEARCOAT", "GBUFFER_EMISSIVE"],
    &["STANDARD_MATERIAL_ANISOTROPY"],
    &["STANDARD_MATERIAL_ANISOTROPY", "GBUFFER_EMISSIVE"],
    &["STANDARD_MATERIAL_DIFFUSE_TRANSMISSION"],
    &["STANDARD_MATERIAL_DIFFUSE_TRANSMISSION", "GBUFFER_EMISSIVE"],
    // Unlit materials may have all of them.
    &[
        "STANDARD_MATERIAL_CLEARCOAT",
        "STANDARD_MATERIAL_CLEARCOAT_NORMAL_MAP",
        "STANDARD_MATERIAL_ANISOTROPY",
        "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION",
    ],
    &["LIGHTMAP", "GBUFFER_EMISSIVE"],
    &["LIGHTMAP", "LIGHTMAP_BICUBIC_SAMPLING", "GBUFFER_EMISSIVE"],
    &["LIGHTMAP", "GBUFFER_EMISSIVE", "GBUFFER_SPECIALIZATION"],
    &[
        "LIGHTMAP",
        "GBUFFER_EMISSIVE",
        "STANDARD_MATERIAL_CLEARCOAT",
    ],
    &[
        "LIGHTMAP",
        "GBUFFER_EMISSIVE",
        "STANDARD_MATERIAL_ANISOTROPY",
    ],
    &[
        "LIGHTMAP",
        "LIGHTMAP_BICUBIC_SAMPLING",
        "GBUFFER_EMISSIVE",
        "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION",
    ],
    // Unlit meshes have no use for their lightmaps.
    &["LIGHTMAP", "GBUFFER_SPECIALIZATION"],
];

/// Definitions of Bevy's `MeshPipeline` and `StandardMaterial` for a mesh that Bevy's passes draw on a lean view, and those of
/// `lighting/forward/definitions.rs`.
pub const FORWARD: &[Factor] = &[
    &[
        &[],
        &["VERTEX_UVS_A"],
        &["VERTEX_UVS_A", "VERTEX_TANGENTS"],
        &["VERTEX_UVS_A", "VERTEX_UVS_B", "VERTEX_TANGENTS"],
    ],
    optional!("VERTEX_COLORS"),
    optional!("MAY_DISCARD"),
    optional!("VISIBILITY_RANGE_DITHER"),
    &[
        &[],
        &["PREMULTIPLY_ALPHA", "BLEND_PREMULTIPLIED_ALPHA"],
        &["PREMULTIPLY_ALPHA", "BLEND_MULTIPLY"],
    ],
    &[
        &[],
        &[
            "MULTIPLE_LIGHTMAPS_IN_ARRAY",
            "MULTIPLE_LIGHT_PROBES_IN_ARRAY",
        ],
        &[
            "MULTIPLE_LIGHTMAPS_IN_ARRAY",
            "MULTIPLE_LIGHT_PROBES_IN_ARRAY",
            "BINDLESS",
        ],
    ],
    optional!("ENVIRONMENT_MAP"),
    &[
        &[],
        &["IRRADIANCE_VOLUMES_ARE_USABLE"],
        &["IRRADIANCE_VOLUMES_ARE_USABLE", "IRRADIANCE_VOLUME"],
    ],
    optional!("SCREEN_SPACE_AMBIENT_OCCLUSION"),
    &[
        &[],
        &["DEPTH_PREPASS"],
        &["DEPTH_PREPASS", "CONTACT_SHADOWS"],
    ],
    optional!("DISTANCE_FOG"),
    optional!("ATMOSPHERE"),
    &[
        &["SHADOW_FILTER_METHOD_HARDWARE_2X2"],
        &["SHADOW_FILTER_METHOD_GAUSSIAN"],
        &["SHADOW_FILTER_METHOD_TEMPORAL"],
    ],
    &[&[], &["PCSS_SAMPLERS_AVAILABLE", "SOFT_SHADOWS"]],
    optional!("BLUE_NOISE_TEXTURE"),
    optional!("DFG_LUT"),
    optional!("AREA_LIGHT_LUTS"),
    &[
        &[],
        &["CLUSTERED_DECALS_ARE_USABLE", "VERTEX_UVS_A"],
        &[
            "CLUSTERED_DECALS_ARE_USABLE",
            "VERTEX_UVS_A",
            "LIGHT_TEXTURES",
        ],
    ],
    &[&[], &["LIGHT_LAYERS", "MESH_LAYERS=5"]],
    optional!("FORWARD_REFLECTIONS", "INDIRECT_SPECULAR", "INDIRECT_LIGHT"),
    &[
        &["VIEW_PROJECTION_NONSTANDARD"],
        &["VIEW_PROJECTION_PERSPECTIVE"],
        &["VIEW_PROJECTION_ORTHOGRAPHIC"],
    ],
    optional!("STANDARD_MATERIAL_NORMAL_MAP"),
    optional!("RELIEF_MAPPING"),
    &[
        &[],
        &["STANDARD_MATERIAL_CLEARCOAT"],
        &["STANDARD_MATERIAL_ANISOTROPY"],
        &["STANDARD_MATERIAL_DIFFUSE_TRANSMISSION"],
        &[
            "STANDARD_MATERIAL_CLEARCOAT",
            "STANDARD_MATERIAL_ANISOTROPY",
            "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION",
        ],
    ],
    // Bevy's `environment_map.wgsl` does not compile with a lightmap and without arrays.
    &[
        &[],
        &[
            "LIGHTMAP",
            "LIGHTMAPPED_SURFACES",
            "MULTIPLE_LIGHTMAPS_IN_ARRAY",
            "MULTIPLE_LIGHT_PROBES_IN_ARRAY",
            "VERTEX_UVS_A",
            "VERTEX_UVS_B",
        ],
    ],
];

/// Definitions that these meshes always have, beside those that `definitions.rs` there always sets.
pub const FORWARD_ALWAYS: [&str; 4] = [
    "MESH_PIPELINE",
    "VERTEX_OUTPUT_INSTANCE_INDEX",
    "VERTEX_POSITIONS",
    "VERTEX_NORMALS",
];

/// Definitions of `MotionResolvePipelines` for a view with motion vectors.
pub const MOTION_RESOLVE: &[Factor] = &[optional!("LATE"), optional!("GBUFFER_MOTION")];

/// Definitions of `ExposureKey::shader_defs` for any settings of auto exposure.
pub const EXPOSURE: &[Factor] = &[
    &[&[], &["LOG_AVERAGE"], &["LOG_AVERAGE", "LOG_OF_PRODUCTS"]],
    &[
        &[],
        &["WEIGHTED", "CENTER_WEIGHTED"],
        &["WEIGHTED", "SPOT"],
        &["WEIGHTED", "MASK"],
    ],
    optional!("HISTOGRAM"),
    optional!("SUBGROUPS"),
];

/// Definitions that never occur without others of the view, mesh or device: with `name` come these.
fn implications(name: &str) -> &'static [&'static str] {
    match name {
        "SPOT_LIGHTS" | "SPHERE_LIGHTS" => &["CLUSTERED_LIGHTS"],
        // Decals are bound in arrays, on devices that bind light probes in arrays too.
        "CLUSTERED_DECALS_ARE_USABLE" => &["MULTIPLE_LIGHT_PROBES_IN_ARRAY"],
        "VERTEX_UVS_A" | "VERTEX_UVS_B" => &["VERTEX_UVS"],
        "LIGHTMAP" => &["VERTEX_UVS_A", "VERTEX_UVS_B", "VERTEX_UVS"],
        "LIGHTMAPPED_SURFACES" => &["GBUFFER_EMISSIVE"],
        "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION" => &[
            "STANDARD_MATERIAL_DIFFUSE_OR_SPECULAR_TRANSMISSION",
            "GBUFFER_SPECIALIZATION",
        ],
        "LISTED_VARIANTS" | "VISITED_VARIANTS" | "SCATTERS_LIGHT" => &["GBUFFER_SPECIALIZATION"],
        "STANDARD_MATERIAL_CLEARCOAT" | "STANDARD_MATERIAL_ANISOTROPY" => {
            &["GBUFFER_SPECIALIZATION"]
        }
        _ => &[],
    }
}

/// The names with all that they imply, in the crate's own rules and in those above.
pub fn with_implied(names: impl IntoIterator<Item = &'static str>) -> HashSet<&'static str> {
    let mut all: HashSet<&'static str> = names.into_iter().collect();
    // Implied names may imply more.
    for _ in 0..2 {
        let more = all
            .iter()
            .flat_map(|name| implications(name).iter().chain(implied_by(name)));
        let more: Vec<&'static str> = more.copied().collect();
        all.extend(more);
    }
    all
}

/// The definitions of a row of choices, with those that are `always` set.
pub fn definitions(row: &[&[&'static str]], always: &[&'static str]) -> HashSet<&'static str> {
    let chosen = row.iter().copied().flatten().copied();
    let all = with_implied(chosen.chain(always.iter().copied()));
    let occur = all
        .iter()
        .filter(|name| occurs(name, |other| all.contains(other)));
    occur.copied().collect()
}

/// True if `name` occurs together with the definitions that the view, mesh or device `has`.
fn occurs(name: &str, has: impl Fn(&str) -> bool) -> bool {
    match name {
        // Added by `material_texture_defs`.
        "PBR_SPECULAR_TEXTURES_SUPPORTED"
        | "PBR_MULTI_LAYER_MATERIAL_TEXTURES_SUPPORTED"
        | "PBR_ANISOTROPY_TEXTURE_SUPPORTED"
        | "PBR_TRANSMISSION_TEXTURES_SUPPORTED" => has("GBUFFER_SPECIALIZATION"),
        // Otherwise materials have no such texture.
        "STANDARD_MATERIAL_CLEARCOAT_NORMAL_MAP" => {
            has("PBR_MULTI_LAYER_MATERIAL_TEXTURES_SUPPORTED")
        }
        _ => true,
    }
}
