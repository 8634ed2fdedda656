//! Mirror images on a floor: of distant things, and where they begin.

use bevy::{
    math::bounding::{Aabb3d, RayCast3d},
    prelude::*,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    analytic_light::{Seen, camera, surface},
    analytic_mirrors::metal,
    headless::Headless,
    own_process::in_own_process,
};

use super::scenes::{EYE, SMALL, looking, mirror_ray, range, reflections, show_next, spawn_floor};

/// A floor's pixel whose mirrored ray hits one of the things on it, or not.
struct FloorPixel {
    pixel: UVec2,
    light: f32,
    hits: bool,
}

/// Pixels that show the floor in front of `things`.
fn floor_before(seen: &Seen, eye: Vec3, things: &[Aabb3d]) -> Vec<FloorPixel> {
    let is_hit = |ray: Ray3d, most: f32| {
        let cast = RayCast3d::from_ray(ray, most);
        things
            .iter()
            .any(|thing| cast.aabb_intersection_at(thing).is_some())
    };
    let places = seen.on_plane(Vec3::ZERO, Vec3::Y);
    let found = places.filter_map(|(pixel, place, light)| {
        let direct = Ray3d::new(eye, Dir3::new(place - eye).ok()?);
        let reflected = mirror_ray(eye, place)?;
        (!is_hit(direct, place.distance(eye))).then(|| FloorPixel {
            pixel,
            light,
            hits: is_hit(reflected, 1e4),
        })
    });
    found.collect()
}

/// A floor mirrors what is so far away that a pixel of a ray is longer than surfaces are thick. With a picture of 90 rows, the eye
/// `h` above the floor and a thickness of `t`, that is from 8h + √(64h² + 2·t·h·f) = 29 m on, where a pixel is 1/f radians high.
#[test]
fn mirrors_show_what_is_far_away() {
    in_own_process(|| {
        show_what_is_far_away(UVec2::new(160, 90), [20.0, 40.0, 60.0, 80.0, 100.0, 150.0]);
    });
}

#[test]
#[ignore = "nightly: a larger picture"]
fn mirrors_in_larger_pictures_show_what_is_far_away() {
    in_own_process(|| show_what_is_far_away(UVec2::new(640, 360), [60.0, 80.0, 150.0]));
}

fn show_what_is_far_away<const N: usize>(size: UVec2, distances: [f32; N]) {
    let mut headless = Headless::new(size);
    let settings = [
        (LeanQuality::Medium, LeanResolution::Half),
        (LeanQuality::High, LeanResolution::Full),
    ];
    for (quality, resolution) in settings {
        for (distance, height) in distances
            .into_iter()
            .zip([1.6, 1.63, 1.55].into_iter().cycle())
        {
            let eye = Vec3::Y * height;
            let half = distance * Vec3::new(0.25, 0.1, 0.05);
            let middle = Vec3::new(0.0, half.y, -distance - half.z);
            let seen = show_next(&mut headless, 6, |s| {
                let floor = Plane3d::default().mesh().size(2000.0, 2000.0);
                s.mesh(floor, metal(0.0), Transform::default());
                let glowing = Cuboid::from_size(2.0 * half);
                s.mesh(
                    glowing,
                    surface(0.0, 1.0),
                    Transform::from_translation(middle),
                );
                let effect = LeanScreenSpaceReflections {
                    quality,
                    resolution,
                    ..reflections()
                };
                camera(s, Transform::from_translation(eye), 0.0, effect);
            });
            seen.save(&format!("far_{distance}_{resolution:?}"), 1.0);
            let pixels = floor_before(&seen, eye, &[Aabb3d::new(middle, half)]);
            // Number of pixels that mirror the box, and their light, by rows.
            let mut rows = vec![(0.0, 0.0); size.y as usize];
            let mut beside = 0.0;
            for FloorPixel { pixel, light, hits } in pixels {
                let row = &mut rows[pixel.y as usize];
                if hits {
                    *row = (row.0 + 1.0, row.1 + light);
                } else {
                    beside += light;
                }
            }
            rows.retain(|(count, _)| *count > 0.0);
            let truth: f32 = rows.iter().map(|(count, _)| count).sum();
            let light: f32 = rows.iter().map(|(_, light)| light).sum();
            let shares: Vec<f32> = rows.iter().map(|(count, light)| light / count).collect();
            let dark = shares.iter().filter(|share| **share < 0.75).count();
            println!(
                "{quality:?}, {resolution:?}, {distance} m: {:.3} of {truth}, {:.3} beside it, {dark} of {} rows are dark",
                light / truth,
                beside / truth,
                rows.len()
            );
            // The upper edge of the box may be hidden in its own pixels.
            assert!(truth > 500.0 && light > 0.9 * truth && light < 1.02 * truth);
            assert!(dark < 2 && beside < 0.12 * truth, "{shares:.2?}");
        }
    }
}

/// No dark line, and no dotted one, is between things and their mirror images.
#[test]
fn mirror_images_begin_where_things_end() {
    in_own_process(|| {
        const GLOW: f32 = 0.9;
        let mut headless = Headless::new(SMALL);
        for (eye, height) in [
            (EYE, 0.3),
            (Vec3::new(0.4, 0.7, 2.2), 0.1),
            (Vec3::new(0.0, 2.2, 2.0), 0.0),
        ] {
            let things = [(-0.55, 0.1, 0.35), (0.5, -0.4, 0.25)].map(|(x, z, half)| {
                let half = Vec3::new(half, 0.4, 0.2);
                Aabb3d::new(Vec3::new(x, half.y, z), half)
            });
            let seen = show_next(&mut headless, 12, |s| {
                spawn_floor(s, metal(0.0), 0.0);
                for thing in things {
                    let size = Vec3::from(thing.max - thing.min);
                    let middle = Vec3::from(thing.max + thing.min) / 2.0;
                    s.mesh(
                        Cuboid::from_size(size),
                        surface(0.0, GLOW),
                        Transform::from_translation(middle),
                    );
                }
                let effect = LeanScreenSpaceReflections {
                    resolution: LeanResolution::Full,
                    ..reflections()
                };
                camera(s, looking(eye, height), 0.0, effect);
            });
            seen.save(&format!("contact_{}", eye.y), 1.0);
            let pixels = floor_before(&seen, eye, &things);
            let is_floor = |pixel: UVec2| pixels.iter().any(|other| other.pixel == pixel);
            let is_mirror = |x: u32, y: u32| {
                let mut mirrors = pixels.iter().filter(|other| other.hits);
                mirrors.any(|other| other.pixel == UVec2::new(x, y))
            };
            // Not the outlines of the images, whose pixels have some of what is beside.
            let contacts = pixels.iter().filter(|at| {
                let UVec2 { x, y } = at.pixel;
                at.hits
                    && y > 0
                    && x > 1
                    && !is_floor(at.pixel - UVec2::Y)
                    && is_mirror(x - 2, y + 1)
                    && is_mirror(x + 2, y + 1)
            });
            let light: Vec<f32> = contacts.map(|at| at.light).collect();
            let (_, most) = range(&light);
            let dark = light.iter().filter(|light| **light < 0.8).count();
            println!(
                "{dark} of {} pixels are dark, the most is {most:.3}",
                light.len()
            );
            assert!(light.len() > 30 && dark * 30 < light.len() && most < 1.02 * GLOW);
        }
    });
}
