//! What Rust and WGSL both know: the layouts of structs, the numbers of bindings, and constants.

use std::collections::BTreeMap;

use bevy::{
    prelude::*,
    reflect::{TypeInfo, Typed},
    render::render_resource::{ShaderType, encase::private::StructMetadata},
    shader::Shader,
};
use bevy_lean_deferred::{
    ambient_occlusion::{self, OcclusionView},
    auto_exposure::{self, ExposureState, ExposureView},
    gbuffer,
    lighting::{LightLayersTable, LightingUniform, binding_numbers as lighting_numbers},
    screen_space::{
        diffuse_gi::{self, GiView},
        history::{self, HistoryView},
        reflections::{self, ReflectionView},
        subsurface::{self, SubsurfaceView},
    },
    shading_extension::ExtensionUniform,
};
use naga::{Module, TypeInner};

use super::permutations::{Definitions, Modules, definition};

/// A shader of the crate, with the definitions under which all that is looked for is in it.
fn compose(source: &'static str, path: &str, definitions: &[&str]) -> Module {
    let definitions: Definitions = definitions.iter().map(|text| definition(text)).collect();
    Modules::new()
        .compose(&Shader::from_wgsl(source, path), definitions)
        .unwrap_or_else(|error| panic!("{path}: {error}"))
}

macro_rules! shader {
    ($path:literal, $($definition:literal),*) => {
        compose(include_str!(concat!("../../src/", $path)), $path, &[$($definition),*])
    };
}

/// As it was written: `naga_oil` appends the module.
fn written(name: &str) -> &str {
    name.split("X_naga_oil").next().unwrap_or(name)
}

/// Compares the names, offsets and size of the fields of `T` with those of the struct `name`.
fn check_struct<T, const N: usize>(module: &Module, name: &str)
where
    T: ShaderType<ExtraMetadata = StructMetadata<N>> + Typed,
{
    let in_rust: Vec<(String, u64)> = match T::type_info() {
        TypeInfo::Struct(info) => (0..N)
            .map(|i| {
                let field = info.field_at(i).expect("as many fields as offsets");
                (field.name().to_string(), T::METADATA.offset(i))
            })
            .collect(),
        _ => panic!("{name} is a struct"),
    };
    let (members, span) = module
        .types
        .iter()
        .find_map(|(_, ty)| match &ty.inner {
            TypeInner::Struct { members, span }
                if ty.name.as_deref().map(written) == Some(name) =>
            {
                Some((members, *span))
            }
            _ => None,
        })
        .unwrap_or_else(|| panic!("no shader uses a struct {name}"));
    let in_wgsl: Vec<(String, u64)> = members
        .iter()
        .map(|member| {
            let name = member.name.clone().expect("fields have names");
            (name, u64::from(member.offset))
        })
        .collect();
    assert_eq!(in_rust, in_wgsl, "{name}");
    assert_eq!(T::min_size().get(), u64::from(span), "the size of {name}");
}

#[test]
fn structs_are_laid_out_alike() {
    let lighting = lighting(&[
        "LIGHT_LAYERS",
        "LEAN_AMBIENT_OCCLUSION",
        "GBUFFER_VISIBILITY_MASK",
    ]);
    check_struct::<LightingUniform, _>(&lighting, "LightingUniform");
    check_struct::<LightLayersTable, _>(&lighting, "LightLayersTable");
    check_struct::<OcclusionView, _>(&lighting, "OcclusionView");
    let adapt = shader!("auto_exposure/adapt.wgsl",);
    check_struct::<ExposureView, _>(&adapt, "ExposureView");
    check_struct::<ExposureState, _>(&adapt, "ExposureState");
    let gather = shader!(
        "screen_space/diffuse_gi/gather.wgsl",
        "DIVISOR=2",
        "SLICES=1",
        "STEPS=1"
    );
    check_struct::<GiView, _>(&gather, "GiView");
    let levels = shader!("screen_space/history/levels.wgsl",);
    check_struct::<HistoryView, _>(&levels, "HistoryView");
    let trace = shader!(
        "screen_space/reflections/trace.wgsl",
        "DIVISOR=2",
        "ROUGH_STEPS=1",
        "SMOOTH_STEPS=1",
        "ROUGH_RAYS=8"
    );
    check_struct::<ReflectionView, _>(&trace, "ReflectionView");
    let down = shader!("screen_space/subsurface/down.wgsl",);
    check_struct::<SubsurfaceView, _>(&down, "SubsurfaceView");
    let extension = shader!("shading_extension/extension.wgsl", "MATERIAL_BIND_GROUP=3");
    check_struct::<ExtensionUniform, _>(&extension, "Extension");
}

/// The lighting shader with what lights everything, and `more`.
fn lighting(more: &[&str]) -> Module {
    const MOST: [&str; 32] = [
        "DEPTH_PREPASS",
        "DIFFUSE_LIGHT",
        "INDIRECT_SPECULAR",
        "INDIRECT_DIFFUSE",
        "INDIRECT_LIGHT",
        "AVAILABLE_STORAGE_BUFFER_BINDINGS=16",
        "GBUFFER_WRITTEN",
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
        "CLUSTERED_SHADOW_MAPS",
        "POINT_SHADOW_MAPS",
        "SPOT_SHADOW_MAPS",
        "SHADOW_FILTER_METHOD_TEMPORAL",
        "BLUE_NOISE_TEXTURE",
        "DFG_LUT",
        "AREA_LIGHT_LUTS",
        "CLUSTERED_DECALS_ARE_USABLE",
        "LIGHT_TEXTURES",
        "VERTEX_TANGENTS",
        "VIEW_PROJECTION_PERSPECTIVE",
        "GEOMETRIC_NORMAL",
        "APPLIES_VISIBILITY",
    ];
    let shows_light = !more.contains(&"DEBUG_VIEW");
    let light = shows_light.then_some(&"SHOWS_LIGHT");
    let definitions: Vec<&str> = MOST.iter().chain(light).chain(more).copied().collect();
    compose(
        include_str!("../../src/lighting/lighting.wgsl"),
        "lighting/lighting.wgsl",
        &definitions,
    )
}

/// The bindings of a group, by the names of their variables in capitals.
fn bindings(modules: &[Module], group: u32) -> BTreeMap<String, u32> {
    bindings_where(modules, group, |_| true)
}

/// As [`bindings`], of the WGSL module alone that declares `variable`. Others come along that no entry point reads.
fn bindings_beside(modules: &[Module], group: u32, variable: &str) -> BTreeMap<String, u32> {
    let origin = modules
        .iter()
        .flat_map(|module| module.global_variables.iter())
        .filter_map(|(_, other)| other.name.as_deref())
        .find_map(|name| (written(name) == variable).then(|| &name[variable.len()..]))
        .unwrap_or_else(|| panic!("no shader has {variable}"));
    bindings_where(modules, group, |name| {
        &name[written(name).len()..] == origin
    })
}

fn bindings_where(
    modules: &[Module],
    group: u32,
    condition: impl Fn(&str) -> bool,
) -> BTreeMap<String, u32> {
    let mut found = BTreeMap::new();
    for (_, variable) in modules.iter().flat_map(|m| m.global_variables.iter()) {
        if let (Some(name), Some(place)) = (&variable.name, &variable.binding)
            && place.group == group
            && condition(name)
        {
            found.insert(written(name).to_uppercase(), place.binding);
        }
    }
    found
}

/// `ours` and `theirs` have the same names, with the same numbers.
fn check_numbers(ours: &[(&str, u32)], theirs: &BTreeMap<String, u32>, where_: &str) {
    let ours: BTreeMap<String, u32> = ours
        .iter()
        .map(|(name, number)| (name.to_string(), *number))
        .collect();
    assert_eq!(&ours, theirs, "{where_}");
}

#[test]
fn bindings_have_the_numbers_of_their_names() {
    use lighting_numbers::{arrays, list, targets, view};
    let modules = [
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
        lighting(&["GBUFFER_MOTION", "DEBUG_VIEW", "DEBUG_MOTION"]),
    ];
    let view_bindings = bindings_beside(&modules, 0, "cluster_offsets_and_counts");
    for (name, number) in view::ALL {
        let expected = (!view::UNUSED.contains(number)).then_some(number);
        let found = view_bindings.get(*name);
        assert_eq!(found, expected, "{name} in bind group 0 of lighting");
    }
    check_numbers(
        arrays::ALL,
        &bindings(&modules, 1),
        "bind group 1 of lighting",
    );
    check_numbers(
        targets::ALL,
        &bindings(&modules, 2),
        "bind group 2 of lighting",
    );
    check_numbers(
        list::ALL,
        &bindings(&modules, 3),
        "bind group 3 of lighting",
    );

    let occlusion = [
        shader!(
            "ambient_occlusion/gather.wgsl",
            "COMPUTE",
            "SHADING_NORMALS",
            "DIVISOR=1",
            "SLICES=1",
            "STEPS=1"
        ),
        shader!("ambient_occlusion/merge.wgsl",),
    ];
    let numbers = ambient_occlusion::binding_numbers::ALL;
    check_numbers(numbers, &bindings(&occlusion, 0), "ambient occlusion");

    let exposure = [
        shader!("auto_exposure/meter.wgsl", "HISTOGRAM", "MASK", "STRIDE=1"),
        shader!("auto_exposure/adapt.wgsl",),
        shader!("auto_exposure/overlay.wgsl", "OVERLAY", "MASK"),
    ];
    let numbers = auto_exposure::binding_numbers::ALL;
    check_numbers(numbers, &bindings(&exposure, 0), "auto exposure");

    let gi = [
        shader!("screen_space/diffuse_gi/levels.wgsl", "DIVISOR=2", "MOTION"),
        shader!(
            "screen_space/diffuse_gi/gather.wgsl",
            "DIVISOR=1",
            "SLICES=1",
            "STEPS=1"
        ),
        shader!("screen_space/diffuse_gi/filter.wgsl", "DIVISOR=1"),
        shader!("screen_space/diffuse_gi/forward_light.wgsl",),
    ];
    let numbers = diffuse_gi::binding_numbers::ALL;
    check_numbers(numbers, &bindings(&gi, 0), "diffuse GI");

    let history = [
        shader!("screen_space/history/levels.wgsl",),
        shader!("screen_space/history/levels.wgsl", "OF_LEVEL"),
    ];
    let numbers = history::binding_numbers::ALL;
    check_numbers(numbers, &bindings(&history, 0), "the history");

    let reflections = [
        shader!("screen_space/reflections/cells.wgsl", "DIVISOR=1"),
        shader!(
            "screen_space/reflections/trace.wgsl",
            "DIVISOR=2",
            "ROUGH_STEPS=1",
            "SMOOTH_STEPS=1",
            "ROUGH_RAYS=8",
            "MOTION",
            "SPECIALIZATION"
        ),
        shader!(
            "screen_space/reflections/resolve.wgsl",
            "DIVISOR=2",
            "PIXELS=16",
            "INVOCATIONS=256",
            "SIDE_SQUARED=144",
            "MEANS_SQUARED=81"
        ),
    ];
    let numbers = reflections::binding_numbers::ALL;
    check_numbers(numbers, &bindings(&reflections, 0), "reflections");

    let scattering = [
        shader!("screen_space/subsurface/down.wgsl", "LISTED"),
        shader!("screen_space/subsurface/down.wgsl",),
        shader!("screen_space/subsurface/up.wgsl",),
        shader!("screen_space/subsurface/up.wgsl", "PICTURE"),
    ];
    let numbers = subsurface::binding_numbers::ALL;
    check_numbers(numbers, &bindings(&scattering, 0), "subsurface scattering");

    let resolve = [
        shader!("gbuffer/resolve_motion.wgsl", "GBUFFER_MOTION"),
        shader!("gbuffer/resolve_motion.wgsl", "LATE"),
    ];
    let numbers = gbuffer::binding_numbers::resolve_motion::ALL;
    check_numbers(numbers, &bindings(&resolve, 0), "the resolve of motion");
}
