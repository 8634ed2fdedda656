//! Constants that both Rust and WGSL declare have one value.

use std::collections::{BTreeMap, BTreeSet};

use bevy::{
    math::{UVec2, Vec3},
    reflect::enums::Enum,
};
use bevy_lean_deferred::{
    effects::{ambient_occlusion::lattice, auto_exposure::key, reflections},
    gbuffer::{GBufferTargets, ShadingModel},
    lighting::{parts::LightingParts, subsurface_light},
    shader_library::tiles,
    shading_models::MODELS,
};
use kit::reference::{
    effects::{auto_exposure::luminance, diffuse_gi::entry, subsurface::profile},
    shader_library::{
        cell, distance_fog, ggx,
        layout::{self, light, motion, specialization},
        reconstruction::position,
    },
    shading_models::{anisotropy, diffuse_transmission, subsurface, unlit},
};
use naga::{Expression, Handle, Literal, Module, TypeInner};

use super::shipped::{self, Place, folder_of};

/// The numbers of a constant: one, or those of a vector.
trait Numbers {
    fn numbers(self) -> Vec<f64>;
}

impl Numbers for u32 {
    fn numbers(self) -> Vec<f64> {
        vec![self.into()]
    }
}

impl Numbers for u64 {
    fn numbers(self) -> Vec<f64> {
        vec![self as f64]
    }
}

impl Numbers for f32 {
    fn numbers(self) -> Vec<f64> {
        vec![self.into()]
    }
}

impl Numbers for UVec2 {
    fn numbers(self) -> Vec<f64> {
        self.to_array().map(f64::from).into()
    }
}

impl Numbers for Vec3 {
    fn numbers(self) -> Vec<f64> {
        self.to_array().map(f64::from).into()
    }
}

/// Rust constants by the WGSL file that declares them too, under the same names.
fn constants_of_rust() -> BTreeMap<Place, Vec<f64>> {
    let mut found = BTreeMap::new();
    macro_rules! constants {
        ($file:literal: $module:ident::{$($name:ident),*}) => {
            $(found.insert(
                ($file.to_string(), stringify!($name).to_string()),
                $module::$name.numbers(),
            );)*
        };
    }
    constants!("shader_library/distance_fog.wgsl": distance_fog::{CLEAR, LINEAR, EXPONENTIAL, LEAST_TRANSMITTANCE});
    constants!("shader_library/ggx.wgsl": ggx::{LEAST_SPREAD});
    constants!("shader_library/layout.wgsl": layout::{
        ALBEDO_MAX, ALBEDO_LIMIT, METALLIC_MAX, DIELECTRIC_CODES, METAL_CODES, MIXED_CODES, FIRST_MIXED, METALLIC_AND_OCCLUSION_CODES, MESH_NORMAL_BIT, ROUGHNESS_MAX, NORMAL_STEPS, HALF_STEPS, NO_GEOMETRY,
        LIGHTMAP_BITS, LIGHTMAP_INCIDENT, LIGHTMAP_REFLECTED
    });
    constants!("shader_library/layout/light.wgsl": light::{LARGEST_LIGHT});
    constants!("shader_library/layout/motion.wgsl": motion::{LARGEST_MOTION});
    constants!("shader_library/layout/specialization.wgsl": specialization::{
        REFLECTANCE_STEPS, LARGEST_REFLECTANCE, DEFAULT_REFLECTANCE, NO_FOG, NO_SHADOWS, ARGUMENTS_SHIFT
    });
    constants!("shader_library/reconstruction/position.wgsl": position::{SMALLEST_DEPTH});
    constants!("shader_library/tiles.wgsl": tiles::{TILE_SIDE});
    constants!("shading_models/anisotropy.wgsl": anisotropy::{FRAME_SEAM});
    constants!("shading_models/diffuse_transmission.wgsl": diffuse_transmission::{THICKNESS_STEPS, LEAST_THICKNESS_LOG});
    constants!("shading_models/subsurface.wgsl": subsurface::{LEAST_PATH_LOG, STEPS});
    constants!("shading_models/unlit.wgsl": unlit::{LARGEST_UNLIT});
    constants!("effects/ambient_occlusion/lattice.wgsl": lattice::{SPACING});
    constants!("effects/auto_exposure/bindings.wgsl": key::{TILE_WIDTH, BINS});
    constants!("effects/auto_exposure/luminance.wgsl": luminance::{WEIGHTS, LARGEST, LOWEST_LOG, SMALLEST});
    constants!("lighting/subsurface_light.wgsl": subsurface_light::{BLOCK_LOG, MASKS});
    constants!("effects/diffuse_gi/entry.wgsl": entry::{
        SURFACE, WEIGHT_SHIFT, LARGEST_WEIGHT, PIXEL, FURTHEST, NEAREST
    });
    constants!("shader_library/cell.wgsl": cell::{FIRST});
    constants!("effects/reflections/lobes.wgsl": reflections::{PHASES});
    constants!("effects/reflections/texels.wgsl": reflections::{WORKGROUP_SIDE});
    constants!("effects/subsurface/profile.wgsl": profile::{REACH, SHORTEST});
    found
}

/// Numbers of Rust's enums and flags in WGSL.
fn numbers_of_rust() -> BTreeMap<Place, Vec<f64>> {
    let info = ShadingModel::Plain.get_represented_enum_info();
    assert_eq!(info.expect("it is an enum").variant_len(), MODELS.len());
    let models = MODELS.map(|model| {
        let file = "shader_library/layout/specialization.wgsl".to_string();
        let place = (file, model.name.to_string());
        (place, (model.model as u32).numbers())
    });
    let targets = GBufferTargets::all().iter_names().map(|(name, target)| {
        let file = "shader_library/layout.wgsl".to_string();
        let place = (file, format!("{name}_VALID"));
        (place, u32::from(target.bits()).numbers())
    });
    let parts = LightingParts::all().iter_names().map(|(name, part)| {
        let place = ("lighting/parts.wgsl".to_string(), name.to_string());
        (place, part.bits().numbers())
    });
    models.into_iter().chain(targets).chain(parts).collect()
}

fn literals(module: &Module, expression: Handle<Expression>, numbers: &mut Vec<f64>) {
    match &module.global_expressions[expression] {
        Expression::Literal(literal) => numbers.push(match *literal {
            Literal::F32(number) => number.into(),
            Literal::U32(number) => number.into(),
            Literal::I32(number) => number.into(),
            Literal::AbstractFloat(number) => number,
            Literal::AbstractInt(number) => number as f64,
            other => panic!("{other:?} is no number"),
        }),
        Expression::Compose { components, .. } => {
            for component in components {
                literals(module, *component, numbers);
            }
        }
        Expression::Splat { size, value } => {
            for _ in 0..*size as usize {
                literals(module, *value, numbers);
            }
        }
        Expression::Constant(constant) => {
            literals(module, module.constants[*constant].init, numbers);
        }
        other => panic!("{other:?} is not worked out"),
    }
}

/// True if a declaration uses only names in `fixed`: names of constants begin with a capital.
fn is_fixed(declaration: &str, fixed: &BTreeMap<&String, &String>) -> bool {
    let (_, value) = declaration.split_once('=').expect("it has a value");
    let mut names = value
        .split(|c: char| !c.is_alphanumeric() && c != '_')
        .filter(|word| word.starts_with(|c: char| c.is_uppercase()));
    !value.contains("#{") && names.all(|name| fixed.contains_key(&name.to_string()))
}

/// Values that naga computes of all constants that do not depend on definitions.
fn constants_of_wgsl() -> BTreeMap<Place, Vec<f64>> {
    let mut of_files: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
    for ((file, name), declaration) in shipped::constants() {
        of_files.entry(file).or_default().insert(name, declaration);
    }
    let mut found = BTreeMap::new();
    for (file, declarations) in &of_files {
        let mut fixed = BTreeMap::new();
        // Each round adds the constants made of earlier ones.
        for _ in declarations {
            let more = declarations.iter();
            let more: Vec<_> = more.filter(|(_, text)| is_fixed(text, &fixed)).collect();
            fixed.extend(more);
        }
        let source: Vec<&str> = fixed.into_values().map(String::as_str).collect();
        let module = naga::front::wgsl::parse_str(&source.join("\n"))
            .unwrap_or_else(|error| panic!("{file}: {error}"));
        for (_, constant) in module.constants.iter() {
            let inner = &module.types[constant.ty].inner;
            // Tables that only shaders have.
            if matches!(inner, TypeInner::Array { .. } | TypeInner::Matrix { .. }) {
                continue;
            }
            let name = constant.name.clone().expect("constants have names");
            let mut numbers = Vec::new();
            literals(&module, constant.init, &mut numbers);
            found.insert((file.clone(), name), numbers);
        }
    }
    found
}

#[test]
fn constants_have_one_value() {
    let in_wgsl = constants_of_wgsl();
    let in_rust = constants_of_rust();
    let all: BTreeMap<Place, Vec<f64>> = in_rust.into_iter().chain(numbers_of_rust()).collect();
    for (place, numbers) in &all {
        assert_eq!(in_wgsl.get(place), Some(numbers), "{place:?}");
    }

    let of_folders = shipped::rust_constants();
    let left_out: BTreeSet<Place> = (shipped::constants())
        .into_keys()
        .filter(|(file, name)| of_folders.contains(&(folder_of(file), name.clone())))
        .filter(|place| !all.contains_key(place))
        .collect();
    assert!(
        left_out.is_empty(),
        "Rust beside these has constants of the same names: {left_out:#?}"
    );
}

/// General lighting pipelines skip each part somewhere.
#[test]
fn parts_of_lighting_are_read() {
    let files = shipped::wgsl();
    for (name, _) in LightingParts::all().iter_names() {
        let read = format!("parts::{name}");
        assert!(files.values().any(|text| text.contains(&read)), "{name}");
    }
}

/// Special shading models have a file each, and the colours of the table in the debug view.
#[test]
fn special_shading_models_have_a_file_and_a_color() {
    let files = shipped::wgsl();
    let debug_view = &files["lighting/debug_view.wgsl"];
    let special = MODELS
        .iter()
        .filter_map(|model| Some((model.name, model.debug_color?)));
    for (name, [r, g, b]) in special.clone() {
        let file = format!("shading_models/{}.wgsl", name.to_lowercase());
        assert!(files.contains_key(&file), "{file}");
        let case = format!("case specialization::{name}: {{ return vec3({r:?}, {g:?}, {b:?}); }}");
        assert!(debug_view.contains(&case), "{case}");
    }
    let cases = debug_view.matches("case specialization::");
    assert_eq!(cases.count(), special.count());
}

/// Relations between constants that other code relies on.
#[test]
fn constants_fit_one_another() {
    let constants = constants_of_wgsl();
    let number = |file: &str, name: &str| {
        let place: Place = (file.into(), name.into());
        constants[&place][0]
    };

    // The number of a material fits into its bits.
    let file = "lighting/subsurface_light.wgsl";
    assert!(number(file, "MOST_MATERIALS") <= number(file, "MATERIAL_BITS"));
    // A row of the dispatch over the list of tiles is no wider than any device allows.
    let limits = wgpu::Limits::downlevel_defaults();
    let widest = f64::from(limits.max_compute_workgroups_per_dimension);
    assert!(number("lighting/tile_list.wgsl", "COLUMNS") <= widest);
    // The first bin of the histogram is the lowest luminance, and the bins reach up to 2 to the power of 16.
    let (file, lowest) = (
        "effects/auto_exposure/bindings.wgsl",
        f64::from(luminance::LOWEST_LOG),
    );
    assert_eq!(number(file, "LOG_OF_FIRST_BIN"), lowest);
    let stops = number(file, "BINS") / number(file, "BINS_PER_STOP");
    assert!((stops - (16.0 - lowest)).abs() < 1e-5, "{stops} stops");
}
