//! The shaders, and the definitions that they are composed under: those of `tests/shaders`.

use naga_oil::compose::ShaderDefValue;

use super::{
    Definitions,
    covering::{Factor, covering_rows},
    factors::{
        EXPOSURE, FORWARD, FORWARD_ALWAYS, GBUFFER, LIGHTING, MOTION_RESOLVE, OCCLUSION_DEBUG_VIEW, OCCLUSION_GATHER,
        OCCLUSION_GATHER_SHARED, OCCLUSION_MERGE, SHARES_DEPTHS, definitions,
    },
};

/// A shader's path in `src`, and its definitions.
type Shader = (&'static str, Vec<Definitions>);

/// Parses a definition: a name, or a name, `=` and a number.
fn definition(text: &str) -> (String, ShaderDefValue) {
    match text.split_once('=') {
        Some((name, value)) => {
            let value = value.parse().expect("the value is a number");
            (name.to_string(), ShaderDefValue::UInt(value))
        }
        None => (text.to_string(), ShaderDefValue::Bool(true)),
    }
}

/// A readable list of the definitions.
pub fn describe(definitions: &Definitions) -> String {
    let mut names: Vec<String> = definitions
        .iter()
        .map(|(name, value)| match value {
            ShaderDefValue::UInt(value) => format!("{name}={value}"),
            _ => name.clone(),
        })
        .collect();
    names.sort();
    names.join(", ")
}

/// Definitions that no device has that `wgpu` 29 creates in a browser: binding arrays, and subgroups (which it does not
/// request from browsers).
const NOT_IN_BROWSERS: [&str; 7] = [
    "BINDLESS",
    "CLUSTERED_DECALS_ARE_USABLE",
    "LIGHT_CULLING_BY_SUBGROUPS",
    "LIGHT_TEXTURES",
    "MULTIPLE_LIGHTMAPS_IN_ARRAY",
    "MULTIPLE_LIGHT_PROBES_IN_ARRAY",
    "SUBGROUPS",
];

/// Rows of `factors` that cover all pairs of choices, and random rows, each with the `always` definitions.
fn rows(factors: &[Factor], always: &str) -> Vec<Definitions> {
    let always: Vec<&'static str> = always.to_string().leak().split_whitespace().collect();
    let mut permutations: Vec<Definitions> = Vec::new();
    for row in covering_rows(factors) {
        let definitions: Definitions = definitions(&row, &always)
            .into_iter()
            .filter(|name| !NOT_IN_BROWSERS.contains(name))
            .map(definition)
            .collect();
        if !permutations.contains(&definitions) {
            permutations.push(definitions);
        }
    }
    permutations
}

/// All combinations of `choices`, which are names separated by spaces, each with the `always` definitions.
fn combinations(always: &str, choices: &[&[&str]]) -> Vec<Definitions> {
    let mut all: Vec<Vec<&str>> = vec![always.split_whitespace().collect()];
    for choice in choices {
        all = all
            .iter()
            .flat_map(|row| {
                choice
                    .iter()
                    .map(move |more| row.iter().copied().chain(more.split_whitespace()).collect())
            })
            .collect();
    }
    all.iter()
        .map(|row| row.iter().map(|text| definition(text)).collect())
        .collect()
}

const PROJECTIONS: &[&str] = &["", "PROJECTION_PERSPECTIVE", "PROJECTION_ORTHOGRAPHIC"];

/// WebGPU's minimum of storage buffers, and the number that SwiftShader and most browsers have.
const LIGHTING_ALWAYS: [&str; 2] = [
    "DEPTH_PREPASS VIEW_PROJECTION_NONSTANDARD AVAILABLE_STORAGE_BUFFER_BINDINGS=8",
    "DEPTH_PREPASS VIEW_PROJECTION_NONSTANDARD AVAILABLE_STORAGE_BUFFER_BINDINGS=10",
];

const GBUFFER_ALWAYS: &str = "PREPASS_PIPELINE PREPASS_FRAGMENT VERTEX_OUTPUT_INSTANCE_INDEX VERTEX_POSITIONS \
    NORMAL_PREPASS_OR_DEFERRED_PREPASS MOTION_VECTOR_PREPASS_OR_DEFERRED_PREPASS DEFERRED_PREPASS MATERIAL_BIND_GROUP=3 \
    AVAILABLE_STORAGE_BUFFER_BINDINGS=8";

/// All shaders of the crate.
pub fn all() -> Vec<Shader> {
    let mut shaders = passes();
    shaders.extend(screen_space());
    shaders
}

/// Variants that gather each pixel's occlusion independently, and variants whose workgroups share depths.
fn occlusion_gathers(values: &str) -> Vec<Definitions> {
    let sharing = format!("{values} {}", SHARES_DEPTHS.join(" "));
    [
        rows(OCCLUSION_GATHER, values),
        rows(OCCLUSION_GATHER_SHARED, &sharing),
    ]
    .concat()
}

fn passes() -> Vec<Shader> {
    let lighting = LIGHTING_ALWAYS
        .map(|always| rows(LIGHTING, always))
        .concat();
    let resolve = "PREPASS_PIPELINE AVAILABLE_STORAGE_BUFFER_BINDINGS=8";
    let gather = ["SLICES=1 STEPS=6", "SLICES=2 STEPS=8"];
    let exposure = || rows(EXPOSURE, "");
    vec![
        ("lighting/lighting.wgsl", lighting),
        ("lighting/forward/forward.wgsl", forward()),
        ("gbuffer/gbuffer.wgsl", rows(GBUFFER, GBUFFER_ALWAYS)),
        ("gbuffer/resolve_motion.wgsl", rows(MOTION_RESOLVE, resolve)),
        (
            "effects/ambient_occlusion/gather.wgsl",
            gather.map(occlusion_gathers).concat(),
        ),
        (
            "effects/ambient_occlusion/merge.wgsl",
            rows(OCCLUSION_MERGE, ""),
        ),
        (
            "effects/ambient_occlusion/debug_view.wgsl",
            rows(OCCLUSION_DEBUG_VIEW, ""),
        ),
        ("effects/auto_exposure/meter.wgsl", exposure()),
        ("effects/auto_exposure/adapt.wgsl", exposure()),
        ("effects/auto_exposure/overlay.wgsl", exposure()),
    ]
}

/// Meshes that Bevy's passes draw.
fn forward() -> Vec<Definitions> {
    let always = format!(
        "{} FORWARD_MESH SPOT_LIGHTS SPHERE_LIGHTS DIRECTIONAL_SHADOW_MAPS POINT_SHADOW_MAPS SPOT_SHADOW_MAPS \
         MATERIAL_BIND_GROUP=3 AVAILABLE_STORAGE_BUFFER_BINDINGS=8",
        FORWARD_ALWAYS.join(" ")
    );
    let mut rows = rows(FORWARD, &always);
    // Bevy's own shader does not compile with both, without binding arrays.
    rows.retain(|row| !(row.contains_key("LIGHTMAP") && row.contains_key("ENVIRONMENT_MAP")));
    rows
}

fn screen_space() -> Vec<Shader> {
    let sides: &[&str] = &["DIVISOR=1", "DIVISOR=2", "DIVISOR=4"];
    let shown: &[&str] = &[
        "SHOWS_LIGHT",
        "SHOWS_BARE_LIGHT",
        "SHOWS_ALPHA",
        "SHOWS_ONE_MINUS_ALPHA",
        "SHOWS_HIT",
    ];
    let listed: &[&str] = &["", "LISTED"];
    let drawn_out: &[&str] = &["", "DRAWN_OUT"];
    vec![
        ("effects/diffuse_gi/levels.wgsl", combinations("", &[])),
        (
            "effects/diffuse_gi/gather.wgsl",
            combinations("SLICES=2 STEPS=3", &[PROJECTIONS]),
        ),
        (
            "effects/diffuse_gi/forward_light.wgsl",
            combinations("", &[]),
        ),
        ("effects/diffuse_gi/filter.wgsl", combinations("", &[])),
        (
            "effects/reflections/hi_z.wgsl",
            combinations("", &[PROJECTIONS]),
        ),
        (
            "effects/reflections/trace.wgsl",
            combinations("", &[PROJECTIONS]),
        ),
        (
            "effects/reflections/spatial_filter.wgsl",
            combinations("SPATIAL_FILTER", &[]),
        ),
        (
            "effects/reflections/resolve.wgsl",
            combinations("", &[sides, PROJECTIONS]),
        ),
        ("effects/subsurface/down.wgsl", combinations("", &[listed])),
        (
            "effects/subsurface/turn.wgsl",
            combinations("", &[drawn_out]),
        ),
        (
            "effects/subsurface/up.wgsl",
            combinations("UNPACKED", &[listed, drawn_out]),
        ),
        (
            "effects/subsurface/picture.wgsl",
            combinations("PICTURE UNPACKED", &[]),
        ),
        (
            "effects/history/levels.wgsl",
            combinations("", &[&["", "OF_LEVEL"]]),
        ),
        (
            "effects/debug_view/debug_view.wgsl",
            combinations("DIVISOR=2", &[shown]),
        ),
    ]
}
