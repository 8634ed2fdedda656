//! The crate's light loop against Bevy's `apply_pbr_lighting`, on the same surfaces, before any rounding.
//!
//! Scenes of the parity suite are lit twice in one shader, which writes the difference.

use bevy::prelude::*;
use bevy_lean_deferred::LeanDeferred;
use kit::{
    hdr::settled_light,
    headless::{Headless, Picture, small_shadow_maps},
    lean::{change_cameras, report, show},
    own_process::in_own_process,
    scenes::{self, Scene, SceneBuilder, daily, nightly},
    shader_files::replace_shader,
    skipped::skips_without_binding_arrays,
};

const SIZE: UVec2 = UVec2::new(160, 120);

/// Share of a scene's pixels that must be within 1e-4 of the expected light, or 1e-5 of white.
const LEAST_SHARE: f64 = 0.999;

/// Surfaces that Bevy's functions are compiled for.
#[derive(Clone, Copy, PartialEq)]
enum Surfaces {
    Usual,
    Lightmapped,
}

/// The lighting shader, changed to write the comparison in place of light.
fn comparing_shader(surfaces: Surfaces) -> String {
    let shader = include_str!("../../src/lighting/lighting.wgsl");
    let shown = "textureStore(output_texture, pixel.position, shaded.color);";
    assert_eq!(shader.matches(shown).count(), 1, "what lighting writes");
    let comparing = "textureStore(output_texture, pixel.position, compared(shaded.color, pixel));";
    let shader = shader.replace(shown, comparing);
    let (imports, functions) = include_str!("oracle.wgsl")
        .split_once("/// Light of the pixel by Bevy")
        .expect("imports, then functions");
    let definition = match surfaces {
        Surfaces::Usual => "",
        Surfaces::Lightmapped => "#define LIGHTMAP\n",
    };
    format!("{definition}{imports}{shader}/// Light of the pixel by Bevy{functions}")
}

fn app(surfaces: Surfaces) -> Headless {
    Headless::with(SIZE, |app| {
        small_shadow_maps(app);
        replace_shader(app, "lighting/lighting.wgsl", comparing_shader(surfaces));
    })
}

/// True if lighting has written the pixel and could compare it.
fn is_compared(texel: &[f32; 4]) -> bool {
    texel[1..] == [0.25, 0.125, 1.0]
}

/// Saves errors to the folder that `ORACLE_PICTURES` names, if set: red, white where too large; blue where not compared.
fn save_errors(name: &str, pixels: &[[f32; 4]]) {
    let Some(folder) = std::env::var_os("ORACLE_PICTURES") else {
        return;
    };
    let color = |texel: &[f32; 4]| match texel[0] {
        _ if !is_compared(texel) => [0, 0, 255, 255],
        error if error > 1.0 => [255; 4],
        error => [(error * 255.0) as u8, 0, 0, 255],
    };
    let picture = Picture {
        size: SIZE,
        rgba: pixels.iter().flat_map(color).collect(),
    };
    picture.save(std::path::Path::new(&folder).join(format!("{name}.png")));
}

/// Prints the number of pixels that could be compared, and of those that are as expected.
fn compare(
    headless: &mut Headless,
    name: &str,
    build: impl FnOnce(&mut SceneBuilder),
) -> Result<(), String> {
    show(headless, build);
    change_cameras(headless, |camera| {
        camera.insert(LeanDeferred::default());
    });
    let pixels = settled_light(headless).texels;
    save_errors(name, &pixels);
    let compared: Vec<f32> = pixels
        .iter()
        .filter(|texel| is_compared(texel))
        .map(|texel| texel[0])
        .collect();
    let good = compared.iter().filter(|error| **error <= 1.0).count();
    let share = good as f64 / compared.len().max(1) as f64;
    let worst = compared.iter().copied().fold(0.0, f32::max);
    let line = format!(
        "{name:32} {:6} pixels, {:.3}% as expected, worst {worst:.2}",
        compared.len(),
        100.0 * share
    );
    println!("{line}");
    if share < LEAST_SHARE {
        Err(line)
    } else {
        Ok(())
    }
}

fn compare_all(scenes: impl IntoIterator<Item = &'static Scene>) {
    let mut headless = app(Surfaces::Usual);
    report((scenes.into_iter()).map(|scene| compare(&mut headless, scene.name, scene.build)));
}

#[test]
fn lights_are_as_bevy_has_them() {
    in_own_process(|| compare_all(daily(scenes::LIGHTS)));
}

#[test]
#[ignore = "nightly: combinations of lights, and materials, which have the same lights"]
fn further_lights_and_materials_are_lit_as_bevy_has_it() {
    in_own_process(|| {
        let materials = scenes::MATERIALS.iter().chain(scenes::FORWARD_MATERIALS);
        compare_all(nightly(scenes::LIGHTS).chain(materials));
    });
}

/// Features to keep of a material, in place of all: Bevy's functions, compiled for several kinds at once, light some wrongly.
type Keep = fn(&mut StandardMaterial);

const ANISOTROPY: Keep = |material| {
    material.clearcoat = 0.0;
    material.diffuse_transmission = 0.0;
};
const COATS: Keep = |material| {
    material.anisotropy_strength = 0.0;
    material.diffuse_transmission = 0.0;
};
const TRANSMISSION: Keep = |material| {
    material.anisotropy_strength = 0.0;
    material.clearcoat = 0.0;
};

/// Compares scenes with special materials.
fn compare_special(keep: Keep, scenes: impl Iterator<Item = &'static Scene> + Clone) {
    let lightmapped = scenes
        .clone()
        .filter(|scene| scene.name.starts_with("lightmapped"));
    compare_kept(Surfaces::Usual, keep, scenes);
    compare_kept(Surfaces::Lightmapped, keep, lightmapped);
}

fn compare_kept(surfaces: Surfaces, keep: Keep, scenes: impl Iterator<Item = &'static Scene>) {
    let mut headless = app(surfaces);
    let device = headless.device().clone();
    // Without binding arrays Bevy's functions do not compile for lightmapped surfaces under an environment map.
    let scenes = scenes.filter(|scene| {
        surfaces == Surfaces::Usual
            || !scene.needs_binding_arrays
            || !skips_without_binding_arrays(&device, scene.name)
    });
    report(scenes.map(|scene| {
        compare(&mut headless, scene.name, |s| {
            (scene.build)(s);
            let mut materials = s.world().resource_mut::<Assets<StandardMaterial>>();
            for (_, material) in materials.iter_mut() {
                keep(material);
            }
        })
    }));
}

/// True for a scene of each kind of light, which has code of its own for each kind of material.
fn is_kind_of_light(scene: &&Scene) -> bool {
    let kinds = [
        "special_sun_and_ambient",
        "special_clustered_lights",
        "special_rect_light",
        "special_environment_map",
        "special_irradiance_volume",
        "special_transmitted_shadows",
        "lightmapped_specials_bicubic",
    ];
    kinds.contains(&scene.name)
}

fn compare_kinds_of_light(keep: Keep) {
    let scenes = scenes::SPECIAL_MATERIALS.iter();
    compare_special(keep, scenes.filter(is_kind_of_light));
}

fn compare_combinations(keep: Keep) {
    let scenes = scenes::SPECIAL_MATERIALS.iter();
    compare_special(keep, scenes.filter(|scene| !is_kind_of_light(scene)));
}

#[test]
fn anisotropic_materials_are_lit_as_bevy_has_it() {
    in_own_process(|| compare_kinds_of_light(ANISOTROPY));
}

#[test]
fn clear_coats_are_lit_as_bevy_has_it() {
    in_own_process(|| compare_kinds_of_light(COATS));
}

#[test]
fn light_shines_through_as_bevy_has_it() {
    in_own_process(|| compare_kinds_of_light(TRANSMISSION));
}

#[test]
#[ignore = "nightly: combinations of lights"]
fn anisotropic_materials_under_further_lights() {
    in_own_process(|| compare_combinations(ANISOTROPY));
}

#[test]
#[ignore = "nightly: combinations of lights"]
fn clear_coats_under_further_lights() {
    in_own_process(|| compare_combinations(COATS));
}

#[test]
#[ignore = "nightly: combinations of lights"]
fn transmission_under_further_lights() {
    in_own_process(|| compare_combinations(TRANSMISSION));
}
