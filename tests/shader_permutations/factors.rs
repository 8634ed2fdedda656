//! The definitions that Bevy and the crate compile shaders with.

use crate::covering::Factor;

/// With or without the definitions.
macro_rules! optional {
    ($($name:literal),+) => {
        &[&[], &[$($name),+]]
    };
}

/// What `LightingPipelines::shader_defs` makes of a view. `implications` adds what never stands alone.
pub const LIGHTING: &[Factor] = &[
    optional!("ENVIRONMENT_MAP"),
    optional!("IRRADIANCE_VOLUME", "IRRADIANCE_VOLUMES_ARE_USABLE"),
    // Bevy's own ambient occlusion, and the crate's.
    optional!("SCREEN_SPACE_AMBIENT_OCCLUSION"),
    &[
        &[],
        &["LEAN_AMBIENT_OCCLUSION"],
        &["LEAN_AMBIENT_OCCLUSION", "OCCLUSION_MULTIBOUNCE"],
        &["LEAN_AMBIENT_OCCLUSION", "OCCLUSION_OF_DIRECT_LIGHT"],
        &["LEAN_AMBIENT_OCCLUSION", "OCCLUSION_DEBUG_VIEW"],
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
    optional!("TEMPORAL_JITTER"),
    &[
        &["SHADOW_FILTER_METHOD_HARDWARE_2X2"],
        &["SHADOW_FILTER_METHOD_GAUSSIAN"],
        &["SHADOW_FILTER_METHOD_TEMPORAL"],
    ],
    PROJECTIONS,
    optional!("BLUE_NOISE_TEXTURE"),
    optional!("DFG_LUT"),
    optional!("AREA_LIGHT_LUTS"),
    optional!("MULTIPLE_LIGHT_PROBES_IN_ARRAY"),
    optional!(
        "CLUSTERED_DECALS_ARE_USABLE",
        "LIGHT_TEXTURES",
        "VERTEX_TANGENTS"
    ),
    &[
        &[],
        &["GEOMETRIC_NORMAL_THREE_TAP", "SHADOW_MAPS"],
        &["GEOMETRIC_NORMAL_FIVE_TAP", "SHADOW_MAPS"],
        &["SHADOW_MAPS"],
    ],
    optional!("DEPTH_TELLS_GEOMETRY"),
    &[
        &[],
        &["DEBUG_ALBEDO"],
        &["DEBUG_METALLIC"],
        &["DEBUG_OCCLUSION"],
        &["DEBUG_NORMAL"],
        &["DEBUG_ROUGHNESS"],
        &["DEBUG_GEOMETRIC_NORMAL"],
        &["DEBUG_DEPTH"],
    ],
];

/// What `FilterKey::shader_defs` makes of the settings of ambient occlusion.
const OCCLUSION_FILTERS: Factor = &[
    &[],
    &["OCCLUSION_FLAT"],
    &["OCCLUSION_EDGE_AWARE"],
    &["OCCLUSION_FLAT", "OCCLUSION_EDGE_AWARE"],
    &["OCCLUSION_HALF"],
    &["OCCLUSION_HALF", "OCCLUSION_EDGE_AWARE"],
];

/// What `GatherKey::shader_defs` makes of a view with ambient occlusion, for both kinds of pass.
pub const OCCLUSION_GATHER: &[Factor] = &[
    &[
        &["SHADING_NORMALS"],
        &["SHADING_NORMALS", "THIN"],
        &[],
        &["THIN"],
        &["HDAO"],
    ],
    optional!("FLOAT16"),
    optional!("COMPUTE"),
    &[
        &["PROJECTION_PERSPECTIVE"],
        &["PROJECTION_ORTHOGRAPHIC"],
        &[],
    ],
];

/// What `OcclusionPipelines::merge` makes of them.
pub const OCCLUSION_MERGE: &[Factor] = &[
    &[&[], &["DISTANCE_FOG"], &["DEBUG_VIEW"]],
    OCCLUSION_FILTERS,
];

const PROJECTIONS: Factor = &[
    &["VIEW_PROJECTION_NONSTANDARD"],
    &["VIEW_PROJECTION_PERSPECTIVE"],
    &["VIEW_PROJECTION_ORTHOGRAPHIC"],
];

/// What Bevy's `PrepassPipeline` and `StandardMaterial` make of a mesh that the G-buffer carries. (A second UV set
/// without a first is missing: Bevy's own `pbr_fragment.wgsl` does not compile with it.)
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
    // Bevy has both where the device has binding arrays, but materials may opt out of `BINDLESS`.
    &[
        &[],
        &["MULTIPLE_LIGHTMAPS_IN_ARRAY"],
        &["MULTIPLE_LIGHTMAPS_IN_ARRAY", "BINDLESS"],
    ],
    &[
        &[],
        &["MOTION_VECTOR_PREPASS"],
        &[
            "MOTION_VECTOR_PREPASS",
            "HAS_PREVIOUS_SKIN",
            "HAS_PREVIOUS_MORPH",
        ],
    ],
    PROJECTIONS,
    optional!("STANDARD_MATERIAL_NORMAL_MAP"),
    optional!("RELIEF_MAPPING"),
    &[
        &[],
        &[
            "STANDARD_MATERIAL_BASE_COLOR_UV_B",
            "STANDARD_MATERIAL_METALLIC_ROUGHNESS_UV_B",
            "STANDARD_MATERIAL_OCCLUSION_UV_B",
            "STANDARD_MATERIAL_NORMAL_MAP_UV_B",
        ],
    ],
];

/// What `ExposureKey::shader_defs` makes of the settings of auto exposure.
pub const EXPOSURE: &[Factor] = &[
    optional!("LOG_AVERAGE"),
    &[
        &[],
        &["WEIGHTED", "CENTER_WEIGHTED"],
        &["WEIGHTED", "SPOT"],
        &["WEIGHTED", "MASK"],
    ],
    optional!("HISTOGRAM"),
    optional!("SUBGROUPS"),
];

/// Names that come with others.
pub fn implications(name: &str) -> &'static [&'static str] {
    match name {
        "SCREEN_SPACE_AMBIENT_OCCLUSION" | "LEAN_AMBIENT_OCCLUSION" => &["APPLIES_VISIBILITY"],
        "CONTACT_SHADOWS" => &["SHADOW_MAPS", "GEOMETRIC_NORMAL"],
        "SHADOW_MAPS" => &["GEOMETRIC_NORMAL"],
        "DEBUG_GEOMETRIC_NORMAL" => &["DEBUG_VIEW", "SHADOW_MAPS", "GEOMETRIC_NORMAL"],
        // Decals are bound in arrays, on the devices on which light probes are too.
        "CLUSTERED_DECALS_ARE_USABLE" => &["MULTIPLE_LIGHT_PROBES_IN_ARRAY"],
        "VERTEX_UVS_A" | "VERTEX_UVS_B" => &["VERTEX_UVS"],
        name if name.starts_with("DEBUG_") => &["DEBUG_VIEW"],
        _ => &[],
    }
}
