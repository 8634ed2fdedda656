//! Reflections of small bright lamps in rough floors: the shape of the lobe, without squares, steady at rest, and no slower than a few
//! frames.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::{
    analytic_lamps::{Lamp, LampScene},
    analytic_light::{Seen, camera, look_at_once, see, surface},
    analytic_mirrors::metal,
    headless::Headless,
    own_process::in_own_process,
};

use super::scenes::{EYE, floor, looking, reflections, show_next, spawn_floor};

const SIZE: UVec2 = UVec2::new(320, 240);
/// Frames until a switched lamp is seen as it stays.
const LAG: usize = 8;

#[test]
fn a_lamp_has_the_shape_of_the_lobe() {
    in_own_process(|| check_shapes([(0.3, 0.036, 1.7)], [8.0]));
}

#[test]
#[ignore = "nightly: further roughness and lights"]
fn further_lamps_have_the_shape_of_the_lobe() {
    in_own_process(|| {
        let floors = [
            (0.1, 0.012, 4.6),
            (0.2, 0.008, 1.85),
            (0.3, 0.036, 1.7),
            (0.5, 0.102, 1.7),
        ];
        check_shapes(floors, [8.0, 200.0]);
    });
}

/// Takes floors: roughness, largest error, and largest difference between pictures of an upright and of a rolled camera, which sees
/// squares.
fn check_shapes<const N: usize>(
    floors: impl IntoIterator<Item = (f32, f32, f32)>,
    lights: [f32; N],
) {
    let mut wrong = Vec::new();
    for (roughness, rmse, rotation) in floors {
        for light in lights {
            let mut scene = LampScene::new(Lamp::OverMetal { light, roughness }, SIZE, |camera| {
                camera.insert(reflections());
            });
            let errors = scene.errors(LAG);
            println!("light {light}, roughness {roughness}: {errors:.4?}");
            if !(errors.rmse < rmse && errors.rotation < rotation) {
                wrong.push((light, roughness));
            }
        }
    }
    assert!(wrong.is_empty(), "light and roughness: {wrong:?}");
}

/// A lamp over a metal floor.
fn lamp(headless: &mut Headless, roughness: f32) -> (Seen, Entity) {
    let mut lamp = Entity::PLACEHOLDER;
    let seen = show_next(headless, 2 * LAG, |s| {
        spawn_floor(s, metal(roughness), 0.0);
        let quad = Rectangle::new(0.1, 0.1);
        lamp = s.mesh(
            quad,
            surface(0.0, 200.0),
            Transform::from_xyz(0.0, 0.4, 0.0),
        );
        let effect = LeanScreenSpaceReflections {
            thickness: 0.02,
            ..reflections()
        };
        camera(s, looking(EYE, 0.3), 0.0, effect);
    });
    (seen, lamp)
}

/// Light of the floor in front of the lamp.
fn floor_sum(seen: &Seen) -> f32 {
    let near = floor(seen).filter(|(place, _)| place.z > 0.02);
    near.map(|(_, light)| light).sum()
}

#[test]
fn lamps_do_not_flicker() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        for roughness in [0.1, 0.3, 0.5] {
            let (first, _) = lamp(&mut headless, roughness);
            first.save(&format!("lamp_{roughness}"), 0.25);
            let peak = floor(&first)
                .filter(|(place, _)| place.z > 0.02)
                .map(|(_, light)| light)
                .fold(0.0, f32::max);
            for _ in 0..LAG {
                let next = look_at_once(&mut headless);
                let pairs = first.light.texels.iter().zip(&next.light.texels);
                let most = pairs.map(|(a, b)| (a[1] - b[1]).abs()).fold(0.0, f32::max);
                println!("roughness {roughness}: at most {most} of {peak}");
                assert!(peak > 0.0 && most <= 1e-3 * peak);
            }
        }
    });
}

#[test]
fn switched_lamps_are_seen_within_a_few_frames() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        for roughness in [0.1, 0.3] {
            let (lit, lamp) = lamp(&mut headless, roughness);
            let lit = floor_sum(&lit);
            for shown in [false, true] {
                let visibility = if shown {
                    Visibility::Visible
                } else {
                    Visibility::Hidden
                };
                headless.world().entity_mut(lamp).insert(visibility);
                let shares: Vec<f32> = (0..LAG)
                    .map(|_| floor_sum(&look_at_once(&mut headless)) / lit)
                    .collect();
                println!("roughness {roughness}, lamp on {shown}: {shares:.3?}");
                let last = shares[LAG - 1];
                assert!(if shown { last > 0.9 } else { last < 0.1 });
                see(&mut headless, LAG);
            }
        }
    });
}
