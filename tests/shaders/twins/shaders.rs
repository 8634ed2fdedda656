//! The shipped shaders, composed so that each of their bindings is in one of them.

use std::{collections::BTreeMap, sync::OnceLock};

use bevy::shader::Shader;
use naga::Module;

use super::{
    super::permutations::{Definitions, Modules, definition},
    shipped::{self, Place},
};

/// Separator that `naga_oil` appends to names, before the path of the module and an `X`.
const DECORATION: &str = "X_naga_oil_mod_X";

/// A shader of the crate, composed with the definitions that include what is compared.
pub struct Composed {
    pub file: &'static str,
    pub module: Module,
    /// The crate's files by their import paths.
    files: BTreeMap<String, String>,
}

impl Composed {
    fn new(source: &'static str, file: &'static str, definitions: &[&str]) -> Self {
        let definitions: Definitions = definitions.iter().map(|text| definition(text)).collect();
        let module = Modules::new()
            .compose(&Shader::from_wgsl(source, file), definitions)
            .unwrap_or_else(|error| panic!("{file}: {error}"));
        let files = shipped::import_paths();
        Self {
            file,
            module,
            files,
        }
    }

    /// Import path of the module that declares `name`; none for the shader itself.
    pub fn import_path(&self, name: &str) -> Option<String> {
        let (_, module) = name.split_once(DECORATION)?;
        Some(decoded(module.strip_suffix('X').expect("it ends in X")))
    }

    /// Place where `name` is declared; `None` if that is in Bevy.
    pub fn place(&self, name: &str) -> Option<Place> {
        let file = match self.import_path(name) {
            Some(path) => self.files.get(&path)?.clone(),
            None => self.file.into(),
        };
        Some((file, written(name).into()))
    }
}

/// The name as written in the source.
pub fn written(name: &str) -> &str {
    name.split(DECORATION).next().unwrap_or(name)
}

/// Decodes a module's path from base 32 (RFC 4648, section 6), without padding.
fn decoded(text: &str) -> String {
    let (mut bytes, mut bits, mut count) = (Vec::new(), 0u32, 0);
    for letter in text.bytes() {
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'2'..=b'7' => letter - b'2' + 26,
            _ => panic!("{text} is not in base 32"),
        };
        bits = (bits << 5) | u32::from(value);
        count += 5;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    String::from_utf8(bytes).expect("paths are UTF-8")
}

macro_rules! shader {
    ($file:literal, $($definition:literal),*) => {
        Composed::new(include_str!(concat!("../../../src/", $file)), $file, &[$($definition),*])
    };
}

/// Lighting with all features, and `more` definitions.
pub fn lighting(more: &[&str]) -> Composed {
    const MOST: [&str; 35] = [
        "DEPTH_PREPASS",
        "DIFFUSE_LIGHT",
        "INDIRECT_SPECULAR",
        "INDIRECT_DIFFUSE",
        "INDIRECT_LIGHT",
        "AVAILABLE_STORAGE_BUFFER_BINDINGS=16",
        "GBUFFER_VALID_MASK",
        "ENVIRONMENT_MAP",
        "IRRADIANCE_VOLUME",
        "IRRADIANCE_VOLUMES_ARE_USABLE",
        "MULTIPLE_LIGHT_PROBES_IN_ARRAY",
        "CONTACT_SHADOWS",
        "DISTANCE_FOG",
        "ATMOSPHERE",
        "SHADOWS",
        "CLUSTERED_LIGHTS",
        "SPOT_LIGHTS",
        "SPHERE_LIGHTS",
        "DIRECTIONAL_SHADOW_MAPS",
        "SEVERAL_DIRECTIONAL_SHADOW_MAPS",
        "CLUSTERED_SHADOW_MAPS",
        "POINT_SHADOW_MAPS",
        "SPOT_SHADOW_MAPS",
        "SOFT_SHADOWS",
        "PCSS_SAMPLERS_AVAILABLE",
        "SHADOW_FILTER_METHOD_TEMPORAL",
        "BLUE_NOISE_TEXTURE",
        "DFG_LUT",
        "AREA_LIGHT_LUTS",
        "CLUSTERED_DECALS_ARE_USABLE",
        "LIGHT_TEXTURES",
        "VERTEX_TANGENTS",
        "VIEW_PROJECTION_NONSTANDARD",
        "GEOMETRIC_NORMAL",
        "APPLIES_VISIBILITY",
    ];
    let definitions: Vec<&str> = MOST.iter().chain(more).copied().collect();
    Composed::new(
        include_str!("../../../src/lighting/lighting.wgsl"),
        "lighting/lighting.wgsl",
        &definitions,
    )
}

/// All shaders.
pub fn all() -> &'static [Composed] {
    static ALL: OnceLock<Vec<Composed>> = OnceLock::new();
    ALL.get_or_init(|| {
        vec![
            lighting(&[
                "LIGHT_LAYERS",
                "GBUFFER_VISIBILITY_MASK",
                "GBUFFER_EMISSIVE",
                "GBUFFER_SPECIALIZATION",
                "LISTED_VARIANTS",
                "LEAN_AMBIENT_OCCLUSION",
                "SCATTERS_LIGHT",
            ]),
            lighting(&["SCREEN_SPACE_AMBIENT_OCCLUSION"]),
            lighting(&[
                "GBUFFER_SPECIALIZATION",
                "VISITED_VARIANTS",
                "STANDARD_MATERIAL_CLEARCOAT",
            ]),
            lighting(&[
                "GBUFFER_MOTION",
                "DEBUG_VIEW",
                "SHOWS_CHANNEL",
                "DEBUG_MOTION",
            ]),
            shader!(
                "lighting/forward/forward.wgsl",
                "FORWARD_MESH",
                "LIGHT_LAYERS",
                "MESH_LAYERS=1",
                "FORWARD_REFLECTIONS",
                "INDIRECT_SPECULAR",
                "INDIRECT_LIGHT",
                "MESH_PIPELINE",
                "VERTEX_OUTPUT_INSTANCE_INDEX",
                "VERTEX_POSITIONS",
                "VERTEX_NORMALS",
                "SHADOW_FILTER_METHOD_GAUSSIAN",
                "VIEW_PROJECTION_NONSTANDARD",
                "MATERIAL_BIND_GROUP=3",
                "AVAILABLE_STORAGE_BUFFER_BINDINGS=16"
            ),
            shader!("effects/ambient_occlusion/sparse_depth.wgsl",),
            shader!(
                "effects/ambient_occlusion/gather.wgsl",
                "COMPUTE",
                "SHARED_DEPTHS",
                "SHADING_NORMALS",
                "SLICES=1",
                "STEPS=1"
            ),
            shader!("effects/ambient_occlusion/merge.wgsl",),
            shader!("effects/ambient_occlusion/debug_view.wgsl",),
            shader!("effects/auto_exposure/meter.wgsl", "HISTOGRAM", "MASK"),
            shader!("effects/auto_exposure/adapt.wgsl",),
            shader!("effects/auto_exposure/overlay.wgsl", "OVERLAY", "MASK"),
            shader!("effects/diffuse_gi/levels.wgsl",),
            shader!("effects/diffuse_gi/gather.wgsl", "SLICES=1", "STEPS=1"),
            shader!("effects/diffuse_gi/filter.wgsl",),
            shader!("effects/diffuse_gi/forward_light.wgsl",),
            shader!("effects/history/levels.wgsl",),
            shader!("effects/history/levels.wgsl", "OF_LEVEL"),
            shader!("effects/reflections/hi_z.wgsl",),
            shader!("effects/reflections/trace.wgsl",),
            shader!("effects/reflections/spatial_filter.wgsl", "SPATIAL_FILTER"),
            shader!("effects/reflections/resolve.wgsl", "DIVISOR=2"),
            shader!("effects/subsurface/down.wgsl", "LISTED"),
            shader!("effects/subsurface/down.wgsl",),
            shader!("effects/subsurface/turn.wgsl",),
            shader!("effects/subsurface/up.wgsl", "UNPACKED"),
            shader!("effects/subsurface/up.wgsl", "UNPACKED", "LISTED"),
            shader!("effects/subsurface/picture.wgsl", "PICTURE", "UNPACKED"),
            shader!(
                "effects/debug_view/debug_view.wgsl",
                "SHOWS_HIT",
                "DIVISOR=2"
            ),
            shader!(
                "effects/debug_view/debug_view.wgsl",
                "SHOWS_LIGHT",
                "DIVISOR=1"
            ),
            shader!("gbuffer/resolve_motion.wgsl", "GBUFFER_MOTION"),
            shader!("gbuffer/resolve_motion.wgsl", "LATE"),
            shader!(
                "gbuffer/gbuffer.wgsl",
                "PREPASS_PIPELINE",
                "PREPASS_FRAGMENT",
                "VERTEX_OUTPUT_INSTANCE_INDEX",
                "VERTEX_POSITIONS",
                "VERTEX_NORMALS",
                "NORMAL_PREPASS_OR_DEFERRED_PREPASS",
                "MOTION_VECTOR_PREPASS_OR_DEFERRED_PREPASS",
                "DEFERRED_PREPASS",
                "GBUFFER_VALID_MASK",
                "GBUFFER_VISIBILITY_MASK",
                "MATERIAL_BIND_GROUP=3",
                "AVAILABLE_STORAGE_BUFFER_BINDINGS=16"
            ),
            shader!("material_extension/extension.wgsl", "MATERIAL_BIND_GROUP=3"),
            shader!(
                "material_extension/extension.wgsl",
                "MATERIAL_BIND_GROUP=3",
                "BINDLESS"
            ),
        ]
    })
}

/// Shaders whose paths below `src` start with `file`.
pub fn of(file: &str) -> impl Iterator<Item = &'static Composed> {
    all()
        .iter()
        .filter(move |composed| composed.file.starts_with(file))
}
