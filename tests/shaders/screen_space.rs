//! The shaders of screen-space lighting effects compose under all definitions that they may get.

use bevy::shader::Shader;

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
    let divisors: &[&str] = &["DIVISOR=1", "DIVISOR=2"];
    check!("diffuse_gi/levels.wgsl", &[], &[divisors, &PROJECTIONS]);
    let samples = ["SLICES=2", "STEPS=3"];
    check!(
        "diffuse_gi/gather.wgsl",
        &samples,
        &[divisors, &PROJECTIONS]
    );
    check!("diffuse_gi/forward_light.wgsl", &[], &[&PROJECTIONS]);
    check!("diffuse_gi/filter.wgsl", &[], &[divisors, &PROJECTIONS]);
}

#[test]
fn reflections_compose() {
    let divisors: &[&str] = &["DIVISOR=1", "DIVISOR=2", "DIVISOR=4"];
    let special: &[&str] = &["", "SPECIALIZATION"];
    let samples = [
        "ROUGH_SEGMENTS=4",
        "SHORTEST_SEGMENT=8",
        "GROWTH_PERCENT=30",
        "SMOOTH_STEPS=8",
    ];
    let choices = [divisors, special, &PROJECTIONS];
    check!("reflections/hi_z.wgsl", &samples, &choices);
    let shown: &[&str] = &["", "SHOWN"];
    let traced = [divisors, special, &PROJECTIONS, shown];
    check!("reflections/trace.wgsl", &samples, &traced);
    check!("reflections/resolve.wgsl", &samples, &choices);
    let lobes: &[&str] = &["SPATIAL_FILTER"];
    let choices = [divisors, special, &PROJECTIONS, lobes];
    check!("reflections/spatial_filter.wgsl", &samples, &choices);
}

#[test]
fn subsurface_scattering_composes() {
    check!(
        "subsurface/down.wgsl",
        &[],
        &[&["", "LISTED"], &["", "PROJECTION_ORTHOGRAPHIC"]]
    );
    let drawn_out: &[&str] = &["", "DRAWN_OUT"];
    let projections: &[&str] = &["", "PROJECTION_ORTHOGRAPHIC"];
    check!("subsurface/turn.wgsl", &[], &[drawn_out, projections]);
    check!(
        "subsurface/up.wgsl",
        &["UNPACKED"],
        &[&["", "LISTED"], drawn_out, projections]
    );
    check!(
        "subsurface/picture.wgsl",
        &["PICTURE", "UNPACKED"],
        &[projections]
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
    check!("debug_view/debug_view.wgsl", &[], &[shown]);
}
