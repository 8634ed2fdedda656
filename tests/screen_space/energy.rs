//! Diffuse GI and reflections on one camera: the light that they take from the environment and the light that they add in its place are
//! equal.

use bevy::prelude::*;
use kit::{
    analytic_light::{Seen, errors, see, surface},
    analytic_mirrors::metal,
    headless::Headless,
    lean::{build, change_cameras},
    own_process::in_own_process,
};

use super::scenes::{SMALL, courtyard, floor_light, gi, reflections};

use bevy_lean_deferred::prelude::*;

/// Material of the things in the furnace, which emit its light and reflect none.
fn glows() -> StandardMaterial {
    surface(0.0, 1.0)
}

/// Surfaces of all kinds. Dark ones reveal specular light best.
fn subjects(perceptual_roughness: f32) -> [(&'static str, StandardMaterial); 5] {
    let dielectric = |albedo: f32| StandardMaterial {
        base_color: Color::linear_rgb(albedo, albedo, albedo),
        perceptual_roughness,
        ..default()
    };
    let coated = |base: StandardMaterial| StandardMaterial {
        clearcoat: 1.0,
        clearcoat_perceptual_roughness: perceptual_roughness,
        perceptual_roughness: 0.5,
        ..base
    };
    [
        ("white dielectric", dielectric(1.0)),
        ("dark dielectric", dielectric(0.0)),
        ("metal", metal(perceptual_roughness)),
        ("coated dielectric", coated(dielectric(0.5))),
        ("coated metal", coated(metal(0.0))),
    ]
}

/// The furnace with a floor of one material and things of another on it, with both effects and without.
fn pictures(
    headless: &mut Headless,
    floor: &StandardMaterial,
    things: &StandardMaterial,
) -> [Seen; 2] {
    let world = headless.world();
    let mut meshes = world.query::<(&MeshMaterial3d<StandardMaterial>, &Transform)>();
    let handles: Vec<_> = meshes
        .iter(world)
        .map(|(material, place)| (material.0.id(), place.translation.y == 0.0))
        .collect();
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    for (id, is_floor) in handles {
        let material = if is_floor { floor } else { things };
        _ = materials.insert(id, material.clone());
    }
    change_cameras(headless, |camera| {
        camera.insert((gi(), reflections()));
    });
    let on = see(headless, 4);
    change_cameras(headless, |camera| {
        camera.remove::<(LeanScreenSpaceGi, LeanScreenSpaceReflections)>();
    });
    [on, see(headless, 1)]
}

/// Everything around emits 1, and so does the sky: each surface reflects the same as under the sky alone.
#[test]
#[ignore = "nightly: a furnace of each effect, for all surfaces"]
fn a_furnace_is_even_for_all_surfaces() {
    in_own_process(|| {
        let mut headless = build(SMALL, |s| {
            courtyard(s, glows(), glows(), 1.0, ());
        });
        let mut all_right = true;
        for roughness in [0.1, 0.4, 1.0] {
            for (name, subject) in subjects(roughness) {
                let [on, off] = pictures(&mut headless, &subject, &glows());
                on.save(&format!("energy_{name}_{roughness}"), 0.5);
                let pairs = floor_light(&on).into_iter().zip(floor_light(&off));
                let differences: Vec<f32> = pairs.map(|(on, off)| on - off).collect();
                let (rmse, bias) = errors(differences.iter().copied());
                let least = differences.iter().copied().fold(0.0, f32::min);
                let most = differences.iter().copied().fold(0.0, f32::max);
                println!(
                    "{name}, roughness {roughness}: {least:+.4} to {most:+.4}, bias {bias:+.4}, RMSE {rmse:.4}"
                );
                // Light is never created. Some is lost where things touch the floor, over a texel or two of the gathered light.
                all_right &= most < 0.002 && bias > -0.01 && rmse < 0.035;
            }
        }
        assert!(all_right);
    });
}
