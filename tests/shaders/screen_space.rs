//! The shaders of effects compose under all definitions that they may get, and passes are compiled by those that they read.

use bevy::shader::Shader;
use bevy_lean_deferred::effects::{auto_exposure, diffuse_gi, reflections, subsurface};

use super::permutations::{Definitions, Modules, definition};

const PROJECTIONS: [&str; 3] = ["", "PROJECTION_PERSPECTIVE", "PROJECTION_ORTHOGRAPHIC"];

/// Composes and validates a shader with all combinations of `choices`.
fn check(source: &'static str, path: &str, always: &[&str], choices: &[&[&str]]) {
    let count: usize = choices.iter().map(|choice| choice.len()).product();
    for mut number in 0..count {
        let mut chosen: Vec<&str> = always.to_vec();
        for choice in choices {
            chosen.extend(choice[number % choice.len()].split_whitespace());
            number /= choice.len();
        }
        let definitions: Definitions = chosen.iter().map(|text| definition(text)).collect();
        Modules::new()
            .compose(&Shader::from_wgsl(source, path), definitions)
            .unwrap_or_else(|error| panic!("{path}, {chosen:?}: {error}"));
    }
}

macro_rules! check {
    ($path:literal, $always:expr, $choices:expr) => {
        check(
            include_str!(concat!("../../src/effects/", $path)),
            $path,
            $always,
            $choices,
        )
    };
}

#[test]
fn diffuse_gi_composes() {
    check!("diffuse_gi/levels.wgsl", &[], &[]);
    let samples = ["SLICES=2", "STEPS=3"];
    check!("diffuse_gi/gather.wgsl", &samples, &[&PROJECTIONS]);
    check!("diffuse_gi/forward_light.wgsl", &[], &[]);
    check!("diffuse_gi/filter.wgsl", &[], &[]);
}

#[test]
fn reflections_compose() {
    let divisors: &[&str] = &["DIVISOR=1", "DIVISOR=2", "DIVISOR=4"];
    check!("reflections/hi_z.wgsl", &[], &[&PROJECTIONS]);
    check!("reflections/trace.wgsl", &[], &[&PROJECTIONS]);
    check!(
        "reflections/spatial_filter.wgsl",
        &["SPATIAL_FILTER"],
        &[&PROJECTIONS]
    );
    check!("reflections/resolve.wgsl", &[], &[divisors, &PROJECTIONS]);
}

#[test]
fn subsurface_scattering_composes() {
    let drawn_out: &[&str] = &["", "DRAWN_OUT"];
    let listed: &[&str] = &["", "LISTED"];
    check!("subsurface/down.wgsl", &[], &[listed]);
    check!("subsurface/turn.wgsl", &[], &[drawn_out]);
    check!("subsurface/up.wgsl", &["UNPACKED"], &[listed, drawn_out]);
    check!("subsurface/picture.wgsl", &["PICTURE", "UNPACKED"], &[]);
}

/// Two values of each definition that keys have. Passes are compared with the first ones of the others.
const KEY_DEFS: [[&str; 2]; 14] = [
    ["SLICES=1", "SLICES=2"],
    ["STEPS=1", "STEPS=2"],
    ["DIVISOR=1", "DIVISOR=2"],
    ["", "PROJECTION_PERSPECTIVE"],
    ["", "PROJECTION_ORTHOGRAPHIC"],
    ["", "DRAWN_OUT"],
    ["", "LOG_AVERAGE"],
    ["", "LOG_OF_PRODUCTS"],
    // Others say how.
    ["WEIGHTED", ""],
    ["", "CENTER_WEIGHTED"],
    ["", "SPOT"],
    ["", "MASK"],
    ["", "HISTOGRAM"],
    ["", "SUBGROUPS"],
];

/// The shader of a pass with the `chosen` values of all definitions.
fn used(
    modules: &mut Modules,
    source: &'static str,
    defs: &[&str],
    chosen: [&str; KEY_DEFS.len()],
) -> String {
    let all = defs.iter().chain(&chosen).filter(|text| !text.is_empty());
    let definitions = all.map(|text| definition(text)).collect();
    modules
        .used(&Shader::from_wgsl(source, "pass.wgsl"), definitions)
        .unwrap_or_else(|error| panic!("{error}"))
}

macro_rules! check_table {
    ($effect:ident: $($file:literal),+) => {
        let sources = [$(include_str!(concat!("../../src/effects/", $file))),+];
        for (pass, source) in $effect::PASSES.iter().zip(sources) {
            let first = KEY_DEFS.map(|[value, _]| value);
            let modules = &mut Modules::new();
            let shader = used(modules, source, pass.defs, first);
            for (number, [_, other]) in KEY_DEFS.into_iter().enumerate() {
                let mut chosen = first;
                chosen[number] = other;
                let (name, _) = definition(other.max(first[number]));
                let is_read = used(modules, source, pass.defs, chosen) != shader;
                let is_named = pass.key_defs.contains(&name.as_str());
                assert_eq!(is_read, is_named, "{}: {name}", pass.label);
            }
        }
    };
}

/// Each pass is compiled anew for those definitions of its effect's key that change its shader, and for no others.
#[test]
fn passes_name_the_definitions_that_they_read() {
    check_table!(
        diffuse_gi:
        "diffuse_gi/levels.wgsl",
        "diffuse_gi/gather.wgsl",
        "diffuse_gi/filter.wgsl"
    );
    check_table!(
        reflections:
        "reflections/hi_z.wgsl",
        "reflections/trace.wgsl",
        "reflections/spatial_filter.wgsl",
        "reflections/resolve.wgsl"
    );
    check_table!(
        subsurface:
        "subsurface/down.wgsl",
        "subsurface/down.wgsl",
        "subsurface/turn.wgsl",
        "subsurface/up.wgsl",
        "subsurface/up.wgsl",
        "subsurface/picture.wgsl"
    );
    check_table!(
        auto_exposure:
        "auto_exposure/meter.wgsl",
        "auto_exposure/adapt.wgsl"
    );
}

#[test]
fn history_and_debug_views_compose() {
    check!("history/levels.wgsl", &[], &[&["", "OF_LEVEL"]]);
    let shown: &[&str] = &[
        "SHOWS_LIGHT",
        "SHOWS_BARE_LIGHT",
        "SHOWS_ALPHA",
        "SHOWS_ONE_MINUS_ALPHA",
        "SHOWS_HIT",
    ];
    check!("debug_view/debug_view.wgsl", &["DIVISOR=2"], &[shown]);
}
