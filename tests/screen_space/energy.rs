//! Diffuse GI and reflections on one camera: what the one takes from the environment and what the other gives in its place
//! are all of the light, and no more.

use bevy::prelude::*;
use kit::{
    headless::Headless,
    known_light::{Seen, errors, see, surface},
    known_mirrors::metal,
    lean::{build, change_cameras},
    own_process::in_own_process,
};

use super::scenes::{SMALL, courtyard, floor_light, gi, reflections};

use bevy_lean_deferred::prelude::*;

/// What stands in the furnace, glows with its light and sends on none.
fn glows() -> StandardMaterial {
    surface(0.0, 1.0)
}

/// Surfaces of all kinds. Dark ones tell most of specular light.
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

/// The furnace with a floor of one material and things on it of another, with both effects and without.
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
    let on = see(headless, 8);
    change_cameras(headless, |camera| {
        camera.remove::<(LeanScreenSpaceGi, LeanScreenSpaceReflections)>();
    });
    [on, see(headless, 1)]
}

/// All that is around glows with 1, and so does the sky: what each surface sends on of that is what it sends on of the sky alone.
#[test]
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
                // Light is never made. Some is lost where things touch the floor, which is a texel or two of what is found.
                all_right &= most < 0.002 && bias > -0.01 && rmse < 0.035;
            }
        }
        assert!(all_right);
    });
}
