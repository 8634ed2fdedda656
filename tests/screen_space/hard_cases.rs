//! Content that the picture does not show, or did not show in the last frame: mirrors that face the camera, things that appear, cameras
//! that jump.

use bevy::{core_pipeline::prepass::DepthPrepass, prelude::*};
use kit::{
    analytic_light::{Seen, camera, errors, look, look_at_once, see, surface},
    analytic_mirrors::{metal, mirror_app},
    headless::Headless,
    lean::{change_cameras, show},
    own_process::in_own_process,
    skipped::on_swiftshader,
};

use super::scenes::{
    EYE, SMALL, floor, gi, light_at, looking, reflections, show_next, spawn_floor, with_motion,
};

/// A mirror that faces the camera reflects rays back to it. They hit the backs of things in between, of which the picture has only the
/// fronts, so these pixels show the environment; others hit the inner side of a wall, which the picture has.
#[test]
fn a_mirror_that_faces_the_camera_shows_no_fronts() {
    in_own_process(|| {
        const EYE: Vec3 = Vec3::new(0.0, 1.2, 3.0);
        const MIRROR_Z: f32 = -3.0;
        const WALL_X: f32 = 1.6;
        const SKY: f32 = 0.3;
        // An odd size: one pixel looks straight ahead, and its ray returns to itself.
        let size = SMALL + 1;
        let mut headless = Headless::new(size);
        let mut picture = |effect: bool| {
            show_next(&mut headless, 8, |s| {
                let mirror = Transform::from_xyz(0.0, EYE.y, MIRROR_Z);
                s.mesh(Rectangle::new(4.0, 3.0), metal(0.0), mirror);
                let inner = Quat::from_rotation_y(-core::f32::consts::FRAC_PI_2);
                let wall = Transform::from_xyz(WALL_X, EYE.y, -2.0).with_rotation(inner);
                s.mesh(Rectangle::new(2.0, 2.0), surface(0.0, 0.8), wall);
                for (x, y) in [(-0.6, 1.2), (0.0, 0.7), (0.3, 1.7)] {
                    let place = Transform::from_xyz(x, y, 0.0);
                    s.mesh(Cuboid::from_length(0.3), surface(0.0, 1.0), place);
                }
                let camera = camera(s, Transform::from_translation(EYE), SKY, ());
                if effect {
                    s.world().entity_mut(camera).insert((gi(), reflections()));
                }
            })
        };
        let [without, seen] = [picture(false), picture(true)];
        seen.save("facing", 0.8);
        assert!(seen.light.texels.iter().flatten().all(|x| x.is_finite()));
        let (mut walls, mut missed, mut skies, mut most) = (0, 0, 0, 0.0_f32);
        for (pixel, place, light) in seen.on_plane(Vec3::Z * MIRROR_Z, Vec3::Z) {
            // Mirror pixels with nothing in front: a white metal shows the sky.
            if place.x.abs() > 1.95 || (without.at(pixel) - SKY).abs() > 0.02 {
                continue;
            }
            let direction = (place - EYE) * Vec3::new(1.0, 1.0, -1.0);
            let met = place + direction * ((WALL_X - place.x) / direction.x);
            let is_on = |rim: f32| {
                direction.x > 0.0
                    && met.z < -1.0 + rim
                    && (met.y - EYE.y).abs() < 1.0 + rim
                    && place.x < WALL_X
            };
            // Excludes two pixels about the wall's outline, and those in front of the edge where wall and mirror meet.
            let beside = WALL_X - place.x;
            if (0.0..0.08).contains(&beside) {
                continue;
            }
            if is_on(-0.08) && light_at(&mut headless, &seen, met).is_some() {
                walls += 1;
                missed += i32::from((light - 0.8).abs() > 0.02);
            } else if !is_on(0.08) {
                skies += 1;
                most = most.max((light - without.at(pixel)).abs());
            }
        }
        println!(
            "{missed} of {walls} pixels do not mirror the wall; {skies} others are off by {most:.4} at most"
        );
        assert!(walls > 300 && skies > 5000 && missed < walls / 50 && most < 2e-3);
    });
}

#[test]
fn what_appears_has_no_light_of_what_was_there() {
    in_own_process(|| check_what_appears(false));
}

#[test]
#[ignore = "nightly: the same with motion vectors"]
fn what_appears_with_motion_vectors_has_no_light_of_what_was_there() {
    in_own_process(|| check_what_appears(true));
}

/// A box appears in front of a wall, one of them dark and the other glowing: in its first frame the box contributes nothing, or a part of
/// the light that was there before; then its own light.
fn check_what_appears(motion: bool) {
    let mut headless = Headless::new(SMALL);
    type Effect<'a> = &'a dyn Fn(&mut EntityWorldMut);
    let mirrors = |camera: &mut EntityWorldMut| {
        camera.insert(reflections());
    };
    let shines = |camera: &mut EntityWorldMut| {
        camera.insert(gi());
    };
    let cases: [(&str, StandardMaterial, Effect, f32); 2] = [
        ("mirror", metal(0.0), &mirrors, 0.05),
        ("diffuse", surface(0.5, 0.0), &shines, 0.002),
    ];
    let mut all_right = true;
    // A tenth of these pixels are the first rows in front of the box. They mirror its foot, which is as far away as the floor that was
    // seen there, within the tolerance of the history: for a frame they have the floor's light.
    let at_rest = on_swiftshader(
        0.15,
        0.12,
        "light of what was there, in a mirror for a frame",
    );
    for (name, material, effect, least) in cases {
        for glow in [0.0, 1.0] {
            let mut thing = Entity::PLACEHOLDER;
            show(&mut headless, |s| {
                spawn_floor(s, material.clone(), 0.0);
                let wall = Transform::from_xyz(0.0, 0.5, -0.8);
                s.mesh(Rectangle::new(3.0, 1.0), surface(0.0, 1.0 - glow), wall);
                let place = Transform::from_xyz(0.0, 0.3, 0.0);
                thing = s.mesh(Cuboid::new(0.8, 0.6, 0.4), surface(0.0, glow), place);
                let camera = camera(s, looking(EYE, 0.2), 0.0, ());
                let mut camera = s.world().entity_mut(camera);
                effect(&mut camera);
                with_motion(motion, &mut camera);
            });
            // Compiles what is needed to draw it.
            headless.settle();
            headless
                .world()
                .entity_mut(thing)
                .insert(Visibility::Hidden);
            let before = see(&mut headless, 12);
            headless
                .world()
                .entity_mut(thing)
                .insert(Visibility::Visible);
            // The first frame that shows it.
            let shows = |seen: &Seen| (seen.at(SMALL / 2) - glow).abs() < 0.01;
            let first = [(); 4]
                .iter()
                .find_map(|()| Some(look_at_once(&mut headless)).filter(shows));
            let first = first.expect("it shows");
            let [second, third] = [(); 2].map(|()| look_at_once(&mut headless));
            let frames = [first, second, third];
            headless.frames(12);
            let still = look(&mut headless);
            for (i, seen) in frames.iter().enumerate() {
                seen.save(&format!("appears_{name}_{glow}_{motion}_{i}"), 1.0);
                assert!(seen.light.texels.iter().flatten().all(|x| x.is_finite()));
            }
            // On the floor in front of the box, where the change is large.
            let sums = |seen: &Seen| -> Vec<f32> {
                let near = floor(seen).zip(floor(&before)).zip(floor(&still));
                let near = near.filter(|(((place, _), (_, before)), (_, still))| {
                    place.z > 0.22 && (before - still).abs() > least
                });
                near.map(|(((_, light), _), _)| light).collect()
            };
            let [first, second, third] = frames.each_ref().map(sums);
            let last = sums(&still);
            let mean = |light: &[f32]| errors(light.iter().copied()).1;
            let off = |light: &[f32]| errors(light.iter().zip(&last).map(|(a, b)| a - b)).0;
            println!(
                "{name}, glows with {glow}, motion vectors {motion}: {} pixels, {:.4} before, then {:.4}, {:.4}, {:.4}, and {:.4}; off by {:.4}, {:.4}",
                last.len(),
                mean(&sums(&before)),
                mean(&first),
                mean(&second),
                mean(&third),
                mean(&last),
                off(&second),
                off(&third),
            );
            assert!(last.len() > 100);
            // At most the light that it finally sends, except at outlines. With motion vectors things may have come nearer: light
            // from no further behind than the assumed thickness is taken for theirs in this frame. At so few pixels diffuse GI also
            // takes the wall for the box in front of it in this frame: 0.03 of its light on the floor.
            let most = if motion { 0.35 } else { at_rest };
            all_right &= mean(&first) < most + mean(&last) * (1.0 - glow);
            all_right &= off(&second) < 0.05 && off(&third) < 0.02;
        }
    }
    assert!(all_right);
}

/// Four frames after a jump the picture equals that of a camera that was always there.
#[test]
#[ignore = "nightly: further frames of what appears"]
fn a_jump_without_a_cut_leaves_no_trail() {
    in_own_process(|| {
        let mut headless = mirror_app(SMALL, 0.0, |camera| {
            camera.insert((gi(), reflections(), DepthPrepass));
        });
        let floor_is_half_diffuse = StandardMaterial {
            metallic: 0.5,
            ..metal(0.1)
        };
        let mut materials = headless.world().resource_mut::<Assets<StandardMaterial>>();
        for (_, material) in materials.iter_mut() {
            if material.metallic > 0.0 {
                *material = floor_is_half_diffuse.clone();
            }
        }
        for motion in [false, true] {
            change_cameras(&mut headless, |camera| with_motion(motion, camera));
            let poses = [
                Transform::from_xyz(0.0, 1.1, 3.2),
                Transform::from_xyz(2.2, 0.6, 1.6),
                Transform::from_xyz(-0.4, 2.4, 2.0),
                Transform::from_xyz(0.0, 1.1, -3.4),
            ];
            see(&mut headless, 8);
            for (i, pose) in poses.into_iter().enumerate().cycle().skip(1).take(4) {
                let middle = Vec3::new(0.0, 0.35, 0.0);
                change_cameras(&mut headless, |camera| {
                    camera.insert(pose.looking_at(middle, Vec3::Y));
                });
                let frames = [(); 5].map(|()| look_at_once(&mut headless));
                headless.frames(8);
                let still = look(&mut headless);
                let off = frames.each_ref().map(|seen| {
                    let pairs = seen.light.texels.iter().zip(&still.light.texels);
                    errors(pairs.map(|(now, still)| now[1] - still[1])).0
                });
                let pairs = frames[4].light.texels.iter().zip(&still.light.texels);
                let most = pairs.map(|(a, b)| (a[1] - b[1]).abs()).fold(0.0, f32::max);
                println!(
                    "motion vectors {motion}, to {i}: off by {off:.4?}, at last {most:.4} at most"
                );
                assert!(off[0] > 0.01 && off[4] < 1e-3 && most < 0.02);
            }
        }
    });
}

#[test]
fn what_is_seen_through_glass_is_mirrored() {
    in_own_process(|| check_glass(false));
}

#[test]
#[ignore = "nightly: the same with motion vectors"]
fn what_is_seen_through_glass_is_mirrored_with_motion_vectors() {
    in_own_process(|| check_glass(true));
}

/// A wall behind a pane of clear glass is reflected as without the pane: rays pass through it, and the picture has the wall's light where
/// the pane has written its depth.
fn check_glass(motion: bool) {
    let mut headless = Headless::new(SMALL);
    let mut pane = Entity::PLACEHOLDER;
    show(&mut headless, |s| {
        spawn_floor(s, metal(0.0), 0.0);
        let wall = Transform::from_xyz(0.0, 0.8, -1.5);
        s.mesh(Rectangle::new(3.0, 1.6), surface(0.0, 0.8), wall);
        let glass = StandardMaterial {
            specular_transmission: 1.0,
            ior: 1.0,
            reflectance: 0.0,
            perceptual_roughness: 0.0,
            ..default()
        };
        let place = Transform::from_xyz(0.0, 0.8, -1.0);
        pane = s.mesh(Rectangle::new(3.6, 1.7), glass, place);
        let camera = camera(s, looking(EYE, 0.3), 0.0, reflections());
        with_motion(motion, &mut s.world().entity_mut(camera));
    });
    let with = see(&mut headless, 8);
    with.save(&format!("glass_{motion}"), 1.0);
    headless.world().despawn(pane);
    let without = see(&mut headless, 8);
    let near = |seen: &Seen| -> f32 {
        let near = floor(seen).filter(|(place, _)| place.z > -0.8);
        near.map(|(_, light)| light).sum()
    };
    let (with, without) = (near(&with), near(&without));
    println!("motion vectors {motion}: {with:.1} through glass, {without:.1} without it");
    assert!(without > 100.0 && (with / without - 1.0).abs() < 0.05);
}
