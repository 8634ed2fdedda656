//! Subsurface scattering: the light that it affects, and the views in which it is seen.

use bevy::{camera::Viewport, prelude::*};
use bevy_lean_deferred::prelude::*;
use kit::{
    analytic_light::{Seen, camera, show},
    analytic_slabs::{SKIN, beside, patterned, slab, step, stored_paths},
    headless::Headless,
    scenes::SceneBuilder,
    skipped::where_light_scatters,
};

use super::scenes::{HIGH, OFF, range, scattering, scattering_camera, show_next};

const SIZE: UVec2 = UVec2::new(320, 192);
const WHITE: LinearRgba = LinearRgba::WHITE;

fn ahead(metres: f32) -> Transform {
    Transform::from_xyz(0.0, 0.0, metres)
}

fn lamp(s: &mut SceneBuilder, place: Vec3) {
    let light = PointLight {
        intensity: 30_000.0,
        ..default()
    };
    s.spawn((light, Transform::from_translation(place)));
}

/// All channels of two pictures, in pairs.
fn channels<'a>(a: &'a Seen, b: &'a Seen) -> impl Iterator<Item = (f32, f32)> + use<'a> {
    let texels = a.light.texels.iter().flatten();
    texels
        .copied()
        .zip(b.light.texels.iter().flatten().copied())
}

fn most_off(a: &Seen, b: &Seen) -> f32 {
    channels(a, b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max)
}

/// The highlight of a lamp over an edge between dark and white: reflectance adds the same to the picture with scattering as without, while
/// diffuse light is blurred.
#[test]
fn highlights_stay_sharp() {
    where_light_scatters(|| {
        let mut headless = Headless::new(SIZE);
        let mut picture = |reflectance, quality| {
            let seen = show_next(&mut headless, 2, |s| {
                let mut material = slab(SKIN, 0.08);
                material.base.reflectance = reflectance;
                material.base.perceptual_roughness = 0.25;
                patterned(s, material, default(), step);
                lamp(s, Vec3::new(0.1, 0.1, 1.0));
                scattering_camera(s, ahead(2.0), 0.0, quality);
            });
            seen.save(&format!("highlight_{reflectance}_{quality:?}"), 0.5);
            seen
        };
        let [off, on] = [OFF, HIGH].map(|quality| [0.0, 0.5].map(|x| picture(x, quality)));
        let specular = |[without, with]: &[Seen; 2]| -> Vec<f32> {
            channels(with, without)
                .map(|(with, without)| with - without)
                .collect()
        };
        let (before, after) = (specular(&off), specular(&on));
        let brightest = before.iter().copied().fold(0.0, f32::max);
        // Rounding of the pictures' half floats, of which the highlight is a difference.
        let rounding = |i: usize| {
            on[1].light.texels[i / 4][i % 4].max(off[1].light.texels[i / 4][i % 4]) / 1024.0
        };
        let worst = before.iter().zip(&after).enumerate();
        let worst = worst.map(|(i, (before, after))| (before - after).abs() - rounding(i));
        let worst = worst.fold(0.0, f32::max);
        let softened = most_off(&off[0], &on[0]);
        println!(
            "at most {brightest:.3}, off by {worst:.5} beyond rounding; diffuse light changes by {softened:.3}"
        );
        assert!(brightest > 0.5 && softened > 0.1 && worst < 1e-3);
    });
}

/// A wide field of view, and a part of a picture.
fn is_daily(view: &str) -> bool {
    ["90 degrees", "a viewport"].contains(&view)
}

#[test]
fn the_edge_is_right_in_any_view() {
    where_light_scatters(|| check_edges(is_daily));
}

#[test]
#[ignore = "nightly: further views"]
fn the_edge_is_right_in_further_views() {
    where_light_scatters(|| check_edges(|view| !is_daily(view)));
}

/// The edge of light on a slab is correct for several fields of view, from afar and near, in small and large pictures, and in a part of
/// one.
fn check_edges(is_asked: fn(&str) -> bool) {
    let mut all_right = true;
    let whole = |size: UVec2| URect::from_corners(UVec2::ZERO, size);
    let part = URect::from_corners(UVec2::new(57, 31), UVec2::new(57, 31) + SIZE);
    let cases = [
        ("20 degrees", SIZE, whole(SIZE), 20.0, 4.7, 0.08),
        ("90 degrees", SIZE, whole(SIZE), 90.0, 0.83, 0.08),
        ("half the size", SIZE / 2, whole(SIZE / 2), 45.0, 2.0, 0.16),
        ("larger", SIZE * 3 / 2, whole(SIZE * 3 / 2), 45.0, 2.0, 0.08),
        ("a viewport", UVec2::new(400, 300), part, 45.0, 2.0, 0.08),
    ];
    for (name, size, viewport, degrees, metres, path) in cases {
        if !is_asked(name) {
            continue;
        }
        let (_, seen) = show(size, 2, |s| {
            patterned(s, slab(WHITE, path), default(), step);
            let shown = Camera {
                viewport: Some(Viewport {
                    physical_position: viewport.min,
                    physical_size: viewport.size(),
                    ..default()
                }),
                ..default()
            };
            let projection = Projection::Perspective(PerspectiveProjection {
                fov: f32::to_radians(degrees),
                ..default()
            });
            camera(
                s,
                ahead(metres),
                1.0,
                (shown, projection, scattering(LeanQuality::High)),
            );
        });
        let seen = seen.within(viewport);
        seen.save(&format!("edge_{name}"), 0.9);
        let found = beside(&seen, Vec3::Z, stored_paths(WHITE, path))[0];
        println!("{name}: {found:.4?}");
        all_right &= found.rmse < 0.01 && found.bias.abs() < 0.002;
    }
    assert!(all_right);
}

const BALL: f32 = 0.35;
/// Half sizes and positions of hairs: about half a pixel wide and centred in one, one pixel wide, and two pixels wide.
const HAIRS: [(Vec3, Vec3); 4] = [
    (Vec3::new(0.002, 0.6, 0.002), Vec3::new(-0.6947, 0.0, 0.0)),
    (Vec3::new(0.004, 0.6, 0.004), Vec3::new(-0.55, 0.0, 0.0)),
    (Vec3::new(0.008, 0.6, 0.008), Vec3::new(0.6, 0.0, 0.0)),
    (Vec3::new(0.008, 0.6, 0.008), Vec3::new(0.1, 0.0, 0.8)),
];

/// A lit ball and hairs in front of a dark slab of the same material have no halo.
#[test]
fn outlines_have_no_halo() {
    where_light_scatters(|| {
        let mut headless = Headless::new(SIZE);
        let path = 0.03;
        let picture = |quality| {
            let seen = show_next(&mut headless, 2, |s| {
                patterned(s, slab(SKIN, path), ahead(-1.5), |_| 0.0);
                let ball = Sphere::new(BALL).mesh().ico(20).expect("few subdivisions");
                let parts = HAIRS.map(|(half, at)| (Cuboid::from_size(2.0 * half).into(), at));
                let material = s.add::<ExtendedStandardMaterial>(slab(SKIN, path));
                for (mesh, at) in parts.into_iter().chain([(ball, Vec3::ZERO)]) {
                    let mesh = s.add::<Mesh>(mesh);
                    let place = Transform::from_translation(at);
                    s.spawn((Mesh3d(mesh), MeshMaterial3d(material.clone()), place));
                }
                lamp(s, Vec3::new(-1.0, 0.6, 1.2));
                scattering_camera(s, ahead(2.0), 0.0, quality);
            });
            seen.save(&format!("outlines_{quality:?}"), 0.9);
            seen
        };
        let [off, on] = [OFF, HIGH].map(picture);
        let (mut outside, mut halo, mut changed) = (0, 0.0_f32, 0.0_f32);
        let mut sums = [[0.0_f32; 2]; HAIRS.len()];
        for (i, ray) in off.rays().iter().enumerate() {
            let (before, after) = (off.light.texels[i], on.light.texels[i]);
            let most = [0, 1, 2].map(|c| (after[c] - before[c]).abs());
            let most = most.into_iter().fold(0.0, f32::max);
            let hair = HAIRS.iter().position(|(half, at)| {
                // Slightly larger than the hair, to include pixels that it covers in part.
                let bounds = bevy::math::bounding::Aabb3d::new(*at, *half + 1e-4);
                let cast = bevy::math::bounding::RayCast3d::from_ray(*ray, 100.0);
                cast.aabb_intersection_at(&bounds).is_some()
            });
            let shows_ball = ray.origin.cross(*ray.direction).length() < BALL + 1e-3;
            if let Some(hair) = hair {
                sums[hair][0] += before[1];
                sums[hair][1] += after[1];
            } else if shows_ball {
                changed = changed.max(most);
            } else {
                outside += 1;
                halo = halo.max(most);
            }
        }
        println!(
            "{outside} pixels outside change by {halo}, the ball by {changed:.3} at most; hairs' sums {sums:.3?}"
        );
        assert!(outside > 20_000 && changed > 0.05);
        assert_eq!(halo, 0.0);
        for [before, after] in sums {
            assert!(before > 1.0 && (after / before - 1.0).abs() < 0.02);
        }
    });
}

/// Paths may be as long as the picture is high, bounded or not: uniform light is unchanged, and an edge makes nothing brighter than the
/// light or darker than 0.
#[test]
fn paths_may_be_longer_than_the_picture() {
    where_light_scatters(|| {
        let mut headless = Headless::new(SIZE / 2);
        let mut picture = |quality, largest_radius, light: fn(Vec2) -> f32| {
            show_next(&mut headless, 2, |s| {
                patterned(s, slab(WHITE, 1.0), default(), light);
                let camera = scattering_camera(s, ahead(0.5), 1.0, quality);
                let mut camera = s.world().entity_mut(camera);
                if let Some(mut effect) = camera.get_mut::<LeanSubsurfaceScattering>() {
                    effect.advanced.largest_radius = largest_radius;
                }
            })
        };
        let [even, half_lit] =
            [|_| 0.7, step as fn(Vec2) -> f32].map(|light| picture(OFF, 0.0, light));
        for largest_radius in [256.0, 1e4, f32::INFINITY] {
            let most = most_off(&even, &picture(HIGH, largest_radius, |_| 0.7));
            let edge = picture(HIGH, largest_radius, step);
            let light: Vec<f32> = edge.light.texels.iter().map(|texel| texel[1]).collect();
            let (least, brightest) = range(&light);
            let changed = most_off(&half_lit, &edge);
            let mean = |seen: &Seen| {
                seen.light.texels.iter().map(|texel| texel[1]).sum::<f32>()
                    / seen.light.texels.len() as f32
            };
            let means = [mean(&half_lit), mean(&edge)];
            println!(
                "up to {largest_radius} pixels: even light off by {most:.5}; an edge {least:.4} to {brightest:.4}, changed by {changed:.3}, mean {means:.4?}"
            );
            assert!(most < 1e-3 && least >= 0.0 && brightest <= 1.001 && changed > 0.1);
            assert!((means[1] - means[0]).abs() < 0.03);
        }
    });
}
