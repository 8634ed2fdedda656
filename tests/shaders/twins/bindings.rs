//! Bindings in WGSL have the numbers of their Rust names.

use std::collections::{BTreeMap, BTreeSet};

use bevy::{prelude::*, render::render_resource::AsBindGroup};
use bevy_lean_deferred::{
    effects::{
        ambient_occlusion, auto_exposure, debug_view, diffuse_gi, history, reflections, subsurface,
    },
    gbuffer,
    lighting::binding_numbers as lighting_numbers,
    material_extension::ShadingExtension,
};
use kit::headless::Headless;

use super::{
    shaders::{self, written},
    shipped::{self, Place},
};

/// Files whose bindings have no Rust counterpart: an example of the documentation, which includes its own Rust.
const NOT_COMPARED: [&str; 1] = ["gbuffer/custom_material.wgsl"];

/// The shader of the lighting pass.
const LIGHTING: &str = "lighting/lighting";

/// Number of a binding, and the place of its declaration if it is the crate's.
type Binding = (u32, Option<Place>);

/// Bindings of a group in the shaders whose paths start with `file`, by variable names in capitals. They are those that the crate declares,
/// or Bevy in the module at `import_path`.
fn bindings(file: &str, group: usize, import_path: Option<&str>) -> BTreeMap<String, Binding> {
    let mut found = BTreeMap::new();
    for composed in shaders::of(file) {
        for (_, variable) in composed.module.global_variables.iter() {
            let (Some(name), Some(binding)) = (&variable.name, &variable.binding) else {
                continue;
            };
            let place = composed.place(name);
            let is_wanted = match import_path {
                Some(path) => composed.import_path(name).as_deref() == Some(path),
                None => place.is_some(),
            };
            if binding.group as usize == group && is_wanted {
                let this = (binding.binding, place);
                let other = found.insert(written(name).to_uppercase(), this.clone());
                let is_same = other.is_none_or(|other| other == this);
                assert!(is_same, "{name} in {file} is declared twice");
            }
        }
    }
    found
}

fn numbers(found: &BTreeMap<String, Binding>) -> BTreeMap<&str, u32> {
    let numbers = found.iter();
    numbers
        .map(|(name, (number, _))| (name.as_str(), *number))
        .collect()
}

/// Asserts that the crate's variables in `group` of the shaders whose paths start with `file` have the numbers `ours`. Returns the places
/// of their declarations.
fn compare(file: &str, group: usize, ours: &[(&str, u32)]) -> Vec<Place> {
    let found = bindings(file, group, None);
    let ours: BTreeMap<&str, u32> = ours.iter().copied().collect();
    assert_eq!(ours, numbers(&found), "bind group {group} of {file}");
    let places = found.into_values().filter_map(|(_, place)| place);
    places.collect()
}

/// Numbers that the derive of `AsBindGroup` assigns, with and without bindless materials.
fn numbers_of_shading_extension() -> [(&'static str, u32); 3] {
    let headless = Headless::new(UVec2::splat(8));
    let entries = ShadingExtension::bind_group_layout_entries(headless.device(), true);
    let [own] = &entries[..] else {
        panic!("it has one binding");
    };
    let bindless = ShadingExtension::bindless_descriptor().expect("it is bindless");
    let [table] = &*bindless.index_tables else {
        panic!("there is one table");
    };
    let [buffer] = &*bindless.buffers else {
        panic!("there is one buffer");
    };
    assert_eq!(table.indices.start.0, own.binding, "of the table");
    [
        ("EXTENSION", own.binding),
        ("INDICES", table.binding_number.0),
        ("EXTENSIONS", buffer.binding_number.0),
    ]
}

#[test]
fn bindings_of_the_view_have_bevys_numbers() {
    use bevy_lean_deferred::lighting::bevy::binding_numbers::{arrays, view};
    let bevys = Some("bevy_pbr::mesh_view_bindings");
    let found = bindings(LIGHTING, 0, bevys);
    for (name, number) in view::ALL {
        let expected = (!view::UNUSED.contains(number)).then_some(number);
        let found = found.get(*name).map(|(number, _)| number);
        assert_eq!(found, expected, "{name}");
    }
    let ours: BTreeMap<&str, u32> = arrays::ALL.iter().copied().collect();
    assert_eq!(ours, numbers(&bindings(LIGHTING, 1, bevys)));
}

#[test]
fn bindings_have_the_numbers_of_their_names() {
    use bevy_lean_deferred::lighting::forward::binding_numbers as forward;
    use gbuffer::binding_numbers::{pack, resolve_motion};
    use lighting_numbers::{list, targets};
    let compared = [
        compare(LIGHTING, 2, targets::ALL),
        compare(LIGHTING, 3, list::ALL),
        compare("lighting/forward/", forward::OWN_GROUP, forward::ALL),
        compare(
            "effects/ambient_occlusion/",
            0,
            ambient_occlusion::binding_numbers::ALL,
        ),
        compare(
            "effects/auto_exposure/",
            0,
            auto_exposure::binding_numbers::ALL,
        ),
        compare("effects/diffuse_gi/", 0, diffuse_gi::binding_numbers::ALL),
        compare("effects/history/", 0, history::binding_numbers::ALL),
        compare("effects/reflections/", 0, reflections::binding_numbers::ALL),
        compare("effects/subsurface/", 0, subsurface::binding_numbers::ALL),
        compare("effects/debug_view/", 0, debug_view::binding_numbers::ALL),
        compare("gbuffer/resolve_motion", 0, resolve_motion::ALL),
        compare("gbuffer/gbuffer", pack::VISIBILITY_MASK_GROUP, pack::ALL),
        compare("material_extension/", 3, &numbers_of_shading_extension()),
    ];
    let compared: BTreeSet<Place> = compared.into_iter().flatten().collect();
    let left_out: Vec<Place> = (shipped::bindings().difference(&compared))
        .filter(|(file, _)| !NOT_COMPARED.contains(&file.as_str()))
        .cloned()
        .collect();
    assert!(left_out.is_empty(), "nothing compares {left_out:?}");
}
