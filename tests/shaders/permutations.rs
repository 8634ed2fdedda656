//! Every shader of the crate composes and validates under any definitions that Bevy and the crate may set.
//!
//! The imported modules come from a running app, so they are the ones that Bevy ships. Nothing is compiled for the device.

mod covering;
mod factors;
mod key_table;

use std::{
    collections::{HashMap, HashSet},
    sync::OnceLock,
};

use bevy::{
    pbr::{MeshPipeline, MeshPipelineKey},
    prelude::*,
    render::RenderApp,
    shader::{Shader, ShaderDefVal, ShaderImport},
};
use bevy_lean_deferred::{
    DebugView,
    lighting::{
        bevy::definitions::{
            OF_BINDINGS, OF_MESHES, VIEW_BITS, name_of, of_mesh_pipeline, read_by_lighting,
        },
        forward::definitions as forward_definitions,
        implied::{self, implied_by},
    },
    shading_models::MODELS,
};
use covering::{Factor, RANDOM_ROWS, covering_rows};
use factors::{
    EXPOSURE, FORWARD, FORWARD_ALWAYS, GBUFFER, LIGHTING, MOTION_RESOLVE, OCCLUSION_DEBUG_VIEW,
    OCCLUSION_GATHER, OCCLUSION_GATHER_SHARED, OCCLUSION_MERGE, SHARES_DEPTHS, definitions,
    with_implied,
};
use kit::headless::Headless;
use naga::{
    back::wgsl::{WriterFlags, write_string},
    compact::{KeepUnused, compact},
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};
use naga_oil::compose::{Composer, NagaModuleDescriptor, ShaderDefValue};

pub type Definitions = HashMap<String, ShaderDefValue>;

/// Parses a definition: a name, or a name, `=` and a number.
pub fn definition(text: &str) -> (String, ShaderDefValue) {
    match text.split_once('=') {
        Some((name, value)) => {
            let value = value.parse().expect("the value is a number");
            (name.to_string(), ShaderDefValue::UInt(value))
        }
        None => (text.to_string(), ShaderDefValue::Bool(true)),
    }
}

/// The shader modules of a running app, by their import name.
fn shipped_shaders() -> &'static HashMap<String, Shader> {
    static SHADERS: OnceLock<HashMap<String, Shader>> = OnceLock::new();
    SHADERS.get_or_init(|| {
        let mut headless = Headless::new(UVec2::splat(8));
        headless.frames(3);
        let shaders = headless.world().resource::<Assets<Shader>>();
        let shaders = shaders.iter().map(|(_, shader)| shader);
        shaders
            .map(|shader| (shader.import_path.module_name().to_string(), shader.clone()))
            .collect()
    })
}

/// Composes shaders as Bevy's `ShaderCache` does.
pub struct Modules {
    composer: Composer,
    capabilities: Capabilities,
}

impl Modules {
    pub fn new() -> Self {
        // Capabilities that binding arrays need, in addition to those of every device.
        let capabilities = Capabilities::default()
            | Capabilities::TEXTURE_AND_SAMPLER_BINDING_ARRAY
            | Capabilities::BUFFER_BINDING_ARRAY
            | Capabilities::STORAGE_BUFFER_BINDING_ARRAY
            | Capabilities::TEXTURE_AND_SAMPLER_BINDING_ARRAY_NON_UNIFORM_INDEXING
            | Capabilities::SHADER_FLOAT16_IN_FLOAT32
            | Capabilities::SUBGROUP;
        Self {
            composer: Composer::default().with_capabilities(capabilities),
            capabilities,
        }
    }

    fn add(&mut self, imports: &[ShaderImport]) -> Result<(), String> {
        for import in imports {
            let name = import.module_name();
            if self.composer.contains_module(&name) {
                continue;
            }
            let shader = shipped_shaders()
                .get(name.as_str())
                .ok_or_else(|| format!("there is no module {name}"))?;
            self.add(&shader.imports)?;
            let added = self
                .composer
                .add_composable_module(shader.into())
                .map(|_| ());
            added.map_err(|error| error.emit_to_string(&self.composer))?;
        }
        Ok(())
    }

    pub fn compose(&mut self, shader: &Shader, defs: Definitions) -> Result<naga::Module, String> {
        self.add(&shader.imports)?;
        let composed = self.composer.make_naga_module(NagaModuleDescriptor {
            shader_defs: defs,
            ..shader.into()
        });
        composed.map_err(|error| error.emit_to_string(&self.composer))
    }

    fn check(&mut self, shader: &Shader, defs: Definitions) -> Result<naga::Module, String> {
        let module = self.compose(shader, defs)?;
        self.validate(&module)?;
        Ok(module)
    }

    fn validate(&self, module: &naga::Module) -> Result<ModuleInfo, String> {
        Validator::new(ValidationFlags::all(), self.capabilities)
            .validate(module)
            .map_err(|error| format!("{:?}", error.into_inner()))
    }

    /// All that the entry points use, as WGSL.
    pub fn used(&mut self, shader: &Shader, defs: Definitions) -> Result<String, String> {
        let module = self.compose(shader, defs)?;
        self.used_of(module)
    }

    /// All that the entry points of `module` use, as WGSL.
    fn used_of(&self, mut module: naga::Module) -> Result<String, String> {
        compact(&mut module, KeepUnused::No);
        let info = self.validate(&module)?;
        write_string(&module, &info, WriterFlags::empty()).map_err(|error| error.to_string())
    }
}

/// Random rows that are checked if nightly tests are not asked for. Rows in which any two choices meet find nearly all errors.
const DAILY_RANDOM_ROWS: usize = 20;

/// Rows of `factors` in which any two choices meet, and random ones.
fn permutations(
    factors: &[Factor],
    always: &[&'static str],
    values: &[(&str, u32)],
) -> Vec<Definitions> {
    let mut permutations = Vec::new();
    let mut rows = covering_rows(factors);
    if std::env::var_os("LEAN_TEST_NIGHTLY").is_none() {
        // The random ones are last.
        rows.truncate(rows.len() - RANDOM_ROWS + DAILY_RANDOM_ROWS);
    }
    for row in rows {
        let row = definitions(&row, always);
        let mut defs: Definitions = row.into_iter().map(definition).collect();
        defs.extend(
            values
                .iter()
                .map(|(name, value)| (name.to_string(), ShaderDefValue::UInt(*value))),
        );
        if !permutations.contains(&defs) {
            permutations.push(defs);
        }
    }
    permutations
}

/// Checks `source` under these [`permutations`]. Returns the definitions of pairs that are the same shader.
fn check_permutations(
    source: &'static str,
    path: &str,
    factors: &[Factor],
    always: &[&'static str],
    values: &[(&str, u32)],
) -> Vec<[String; 2]> {
    let shader = Shader::from_wgsl(source, path);
    let mut modules = Modules::new();
    let permutations = permutations(factors, always, values);
    println!("{path}: {} permutations", permutations.len());
    let mut checked = HashMap::new();
    let mut twins = Vec::new();
    for defs in permutations {
        let names = names_of(&defs).join(", ");
        let module = modules.check(&shader, defs);
        let used = module.and_then(|module| modules.used_of(module));
        let used = used.unwrap_or_else(|error| panic!("{path} with {names}:\n{error}"));
        if let Some(other) = checked.insert(used, names.clone()) {
            twins.push([other, names]);
        }
    }
    twins
}

/// The definitions, in alphabetical order.
fn names_of(defs: &Definitions) -> Vec<String> {
    let names = defs.iter().map(|(name, value)| match value {
        ShaderDefValue::UInt(value) => format!("{name}={value}"),
        _ => name.clone(),
    });
    let mut names: Vec<_> = names.collect();
    names.sort();
    names
}

/// Definitions that lighting always has.
const LIGHTING_ALWAYS: [&str; 2] = ["DEPTH_PREPASS", "VIEW_PROJECTION_NONSTANDARD"];

/// Checks lighting, whose permutations are different shaders: nothing is compiled twice.
fn check_lighting(storage_buffers: u32) {
    let twins = check_permutations(
        include_str!("../../src/lighting/lighting.wgsl"),
        "src/lighting/lighting.wgsl",
        LIGHTING,
        &LIGHTING_ALWAYS,
        &[("AVAILABLE_STORAGE_BUFFER_BINDINGS", storage_buffers)],
    );
    assert!(twins.is_empty(), "{twins:#?}");
}

/// With as many bindings as the crate requires of a device.
#[test]
fn lighting_permutations_validate_on_the_least_device() {
    check_lighting(3);
}

/// With enough bindings for everything.
#[test]
fn lighting_permutations_validate() {
    check_lighting(16);
}

#[test]
fn gbuffer_permutations_validate() {
    check_permutations(
        include_str!("../../src/gbuffer/gbuffer.wgsl"),
        "src/gbuffer/gbuffer.wgsl",
        GBUFFER,
        &[
            "PREPASS_PIPELINE",
            "PREPASS_FRAGMENT",
            "VERTEX_OUTPUT_INSTANCE_INDEX",
            "VERTEX_POSITIONS",
            "NORMAL_PREPASS_OR_DEFERRED_PREPASS",
            "MOTION_VECTOR_PREPASS_OR_DEFERRED_PREPASS",
            "DEFERRED_PREPASS",
        ],
        &[
            ("MATERIAL_BIND_GROUP", 3),
            ("AVAILABLE_STORAGE_BUFFER_BINDINGS", 16),
        ],
    );
}

/// Definitions that meshes of Bevy's passes always have.
fn forward_always() -> Vec<&'static str> {
    [&FORWARD_ALWAYS[..], &forward_definitions::ALWAYS].concat()
}

#[test]
fn forward_permutations_validate() {
    check_permutations(
        include_str!("../../src/lighting/forward/forward.wgsl"),
        "src/lighting/forward/forward.wgsl",
        FORWARD,
        &forward_always(),
        &[
            ("MATERIAL_BIND_GROUP", 3),
            ("AVAILABLE_STORAGE_BUFFER_BINDINGS", 16),
        ],
    );
}

#[test]
fn every_definition_of_the_forward_shader_is_tried() {
    let tried = tried(FORWARD, &forward_always());
    let definitions = include_str!("../../src/lighting/forward/definitions.rs");
    assert_all_tried("definitions.rs", definitions, &tried);
}

#[test]
fn motion_resolve_permutations_validate() {
    check_permutations(
        include_str!("../../src/gbuffer/resolve_motion.wgsl"),
        "src/gbuffer/resolve_motion.wgsl",
        MOTION_RESOLVE,
        &["PREPASS_PIPELINE"],
        &[("AVAILABLE_STORAGE_BUFFER_BINDINGS", 16)],
    );
}

#[test]
fn occlusion_permutations_validate() {
    let values: [&[_]; 2] = [
        &[("SLICES", 1), ("STEPS", 6)],
        &[("SLICES", 2), ("STEPS", 8)],
    ];
    let gathers: [(_, &[_]); 2] = [
        (OCCLUSION_GATHER, &[]),
        (OCCLUSION_GATHER_SHARED, &SHARES_DEPTHS),
    ];
    for values in values {
        for (factors, always) in gathers {
            check_permutations(
                include_str!("../../src/effects/ambient_occlusion/gather.wgsl"),
                "src/effects/ambient_occlusion/gather.wgsl",
                factors,
                always,
                values,
            );
        }
    }
    check_permutations(
        include_str!("../../src/effects/ambient_occlusion/sparse_depth.wgsl"),
        "src/effects/ambient_occlusion/sparse_depth.wgsl",
        &[],
        &[],
        &[],
    );
    check_permutations(
        include_str!("../../src/effects/ambient_occlusion/merge.wgsl"),
        "src/effects/ambient_occlusion/merge.wgsl",
        OCCLUSION_MERGE,
        &[],
        &[],
    );
    check_permutations(
        include_str!("../../src/effects/ambient_occlusion/debug_view.wgsl"),
        "src/effects/ambient_occlusion/debug_view.wgsl",
        OCCLUSION_DEBUG_VIEW,
        &[],
        &[],
    );
}

#[test]
fn exposure_permutations_validate() {
    for (source, path) in [
        (
            include_str!("../../src/effects/auto_exposure/meter.wgsl"),
            "src/effects/auto_exposure/meter.wgsl",
        ),
        (
            include_str!("../../src/effects/auto_exposure/adapt.wgsl"),
            "src/effects/auto_exposure/adapt.wgsl",
        ),
        (
            include_str!("../../src/effects/auto_exposure/overlay.wgsl"),
            "src/effects/auto_exposure/overlay.wgsl",
        ),
    ] {
        check_permutations(source, path, EXPOSURE, &[], &[]);
    }
}

/// Names in the factors, and those that they imply.
fn tried(factors: &[Factor], always: &[&'static str]) -> HashSet<&'static str> {
    let names = factors
        .iter()
        .copied()
        .flatten()
        .copied()
        .flatten()
        .copied();
    with_implied(names.chain(always.iter().copied()))
        .into_iter()
        .map(|name| name.split_once('=').map_or(name, |(name, _)| name))
        .collect()
}

/// Definitions that a source names. Names that end in `_` are the beginnings of several.
fn named(source: &str) -> impl Iterator<Item = &str> {
    let is_definition = |text: &&str| {
        !text.is_empty()
            && !text.ends_with('_')
            && text
                .chars()
                .all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
    };
    // Every second part is text between quotes.
    let parts = source.split('"').skip(1).step_by(2);
    parts.filter(is_definition)
}

/// Panics if `pipeline` names a definition that is not tried.
fn assert_all_tried(path: &str, pipeline: &str, tried: &HashSet<&str>) {
    let unknown: Vec<&str> = named(pipeline)
        .filter(|name| !tried.contains(name))
        .collect();
    assert!(
        unknown.is_empty(),
        "{path} defines {unknown:?}, which no permutation has"
    );
}

#[test]
fn every_definition_of_the_occlusion_shaders_is_tried() {
    let values = ["SLICES", "STEPS"];
    let tried = &(&tried(OCCLUSION_GATHER, &values) | &tried(OCCLUSION_MERGE, &[]))
        | &tried(OCCLUSION_GATHER_SHARED, &SHARES_DEPTHS);
    let keys = include_str!("../../src/effects/ambient_occlusion/key.rs");
    assert_all_tried("key.rs", keys, &tried);
}

#[test]
fn every_definition_of_the_exposure_shaders_is_tried() {
    let key = include_str!("../../src/effects/auto_exposure/key.rs");
    assert_all_tried("key.rs", key, &tried(EXPOSURE, &[]));
}

/// Names of the definitions that Bevy's mesh pipeline sets for any view, on any device.
fn bevys_definitions() -> HashSet<String> {
    use MeshPipelineKey as Key;
    let mut headless = Headless::new(UVec2::splat(8));
    headless.frames(3);
    let world = headless.app.sub_app(RenderApp).world();
    let pipeline = MeshPipeline {
        binding_arrays_are_usable: true,
        clustered_decals_are_usable: true,
        ..world.resource::<MeshPipeline>().clone()
    };
    let flags = (VIEW_BITS - Key::SHADOW_FILTER_METHOD_RESERVED_BITS) | Key::DEPTH_PREPASS;
    let filters = [
        Key::SHADOW_FILTER_METHOD_HARDWARE_2X2,
        Key::SHADOW_FILTER_METHOD_GAUSSIAN,
        Key::SHADOW_FILTER_METHOD_TEMPORAL,
    ];
    filters
        .into_iter()
        .flat_map(|filter| of_mesh_pipeline(&pipeline, flags | filter))
        .map(|definition| name_of(&definition).to_string())
        .collect()
}

/// Whatever bindings Bevy has, shaders read none that the view's layouts leave out.
#[test]
fn bevys_bindings_that_are_left_out_are_not_read() {
    let bevys = OF_BINDINGS.map(|(name, _)| ShaderDefVal::from(name));
    for (left_out, missing) in OF_BINDINGS {
        let read = read_by_lighting(bevys.to_vec(), |binding| binding != missing);
        for (name, binding) in OF_BINDINGS {
            let is_read = read.iter().any(|definition| name_of(definition) == name);
            assert_eq!(is_read, binding != missing, "{name} without {left_out}");
        }
    }
}

/// The Rust side of the lighting shader passes Bevy's definitions on as they are: it sets none by a rule of its own.
#[test]
fn bevys_definitions_are_tried_and_not_restated() {
    let bevys = bevys_definitions();
    let tried = tried(LIGHTING, &LIGHTING_ALWAYS);
    for name in &bevys {
        let is_of_meshes = OF_MESHES.contains(&name.as_str());
        assert_ne!(is_of_meshes, tried.contains(name.as_str()), "{name}");
    }
    let set = named(include_str!("../../src/lighting/definitions.rs"));
    let implied = tried.iter().flat_map(|name| implied_by(name)).copied();
    for name in set.chain(implied) {
        assert!(!bevys.contains(name), "{name} is defined anew");
    }
}

#[test]
fn every_definition_of_the_lighting_shader_is_tried() {
    let tried = tried(LIGHTING, &LIGHTING_ALWAYS);
    let definitions = include_str!("../../src/lighting/definitions.rs");
    assert_all_tried("definitions.rs", definitions, &tried);
    let implied = include_str!("../../src/lighting/implied.rs");
    let of_forward = self::tried(FORWARD, &forward_always());
    assert_all_tried("implied.rs", implied, &(&tried | &of_forward));
    for name in MODELS.iter().filter_map(|model| model.shader_def) {
        assert!(tried.contains(name), "{name}");
    }
    let inputs_and_outputs = include_str!("../../src/view/lighting_io.rs");
    assert_all_tried("lighting_io.rs", inputs_and_outputs, &tried);
    let targets = include_str!("../../src/gbuffer/targets.rs");
    assert_all_tried("targets.rs", targets, &tried);
    let views = DebugView::ALL.into_iter().filter_map(DebugView::shader_def);
    let views: HashSet<&str> = views.chain(["DEBUG_VIEW"]).collect();
    let tried = tried.into_iter().filter(|name| name.starts_with("DEBUG_"));
    assert_eq!(tried.collect::<HashSet<&str>>(), views);
}

#[test]
fn every_definition_of_the_gbuffer_shader_is_tried() {
    let tried = tried(GBUFFER, &[]);
    let material = include_str!("../../src/gbuffer/material.rs");
    assert_all_tried("material.rs", material, &tried);
    let targets = include_str!("../../src/gbuffer/targets.rs");
    assert_all_tried("targets.rs", targets, &tried);
}
