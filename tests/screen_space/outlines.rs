//! Outlines in glossy mirrors: of things before a bright wall, and of the wall itself.

use bevy::{math::bounding::*, prelude::*};
use kit::{
    analytic_light::{Seen, camera, errors, surface},
    analytic_mirrors::metal,
    headless::Headless,
    own_process::in_own_process,
};

use super::scenes::{EYE, looking, mirrored, reflections, show_next, spawn_floor};

const SIZE: UVec2 = UVec2::new(480, 270);
const BALL: f32 = 0.12;
const DARK_BALL: Vec3 = Vec3::new(-0.8, 0.3, -0.4);
const BRIGHT_BALL: Vec3 = Vec3::new(0.0, 0.3, -0.4);
const PILLAR: Vec3 = Vec3::new(0.15, 1.0, 0.12);
const WALL: Vec3 = Vec3::new(5.0, 1.2, 0.1);
/// Front of the wall.
const WALL_AT: f32 = -1.95;

/// A metal floor before a wall with a light of 1, with dark and bright things between them.
fn things_before_a_wall(headless: &mut Headless, roughness: f32) -> Seen {
    show_next(headless, 16, |s| {
        spawn_floor(s, metal(roughness), 0.0);
        let back = WALL_AT - 0.5 * WALL.z;
        let wall = Transform::from_xyz(0.0, 0.5 * WALL.y, back);
        s.mesh(Cuboid::from_size(WALL), surface(0.0, 1.0), wall);
        for x in [-1.2, 0.4] {
            let at = Transform::from_xyz(x, 0.5 * PILLAR.y, -0.8);
            s.mesh(Cuboid::from_size(PILLAR), surface(0.0, 0.0), at);
        }
        for (at, light) in [(DARK_BALL, 0.0), (BRIGHT_BALL, 3.0)] {
            let ball = Sphere::new(BALL).mesh().uv(32, 18);
            s.mesh(ball, surface(0.0, light), Transform::from_translation(at));
        }
        camera(s, looking(EYE, 0.3), 0.0, reflections());
    })
}

/// The floor's pixels, the rays that they mirror, and their light.
fn floor_rays(seen: &Seen) -> Vec<(UVec2, Ray3d, f32)> {
    seen.on_plane(Vec3::ZERO, Vec3::Y)
        .filter_map(|(pixel, place, light)| {
            let direction = Dir3::new(mirrored(EYE, place)).ok()?;
            Some((pixel, Ray3d::new(place, direction), light))
        })
        .collect()
}

/// Light of the pixels that mirror a ball, up to this share of its radius.
fn ball_light(rays: &[(UVec2, Ray3d, f32)], centre: Vec3, share: f32) -> Vec<f32> {
    let inner = BoundingSphere::new(centre, share * BALL);
    rays.iter()
        .filter(|(_, ray, _)| {
            let cast = RayCast3d::from_ray(*ray, 10.0);
            cast.sphere_intersection_at(&inner).is_some()
        })
        .map(|(.., light)| *light)
        .collect()
}

/// Light of the pixels whose rays pass over the wall, but so close to a pillar that blurred levels of the last frame have the wall in them.
fn rim_light(rays: &[(UVec2, Ray3d, f32)]) -> Vec<f32> {
    rays.iter()
        .filter(|(_, ray, _)| {
            let over = ray.get_point((WALL_AT - ray.origin.z) / ray.direction.z).y > 1.25 * WALL.y;
            let beside = ray.get_point((-0.8 - ray.origin.z) / ray.direction.z);
            let is_near = [-1.2, 0.4].iter().any(|x| (beside.x - x).abs() < PILLAR.x);
            over && is_near
        })
        .map(|(.., light)| *light)
        .collect()
}

/// Difference of the image of the wall's upper edge from its mean along each row of pixels (RMS).
fn hatching(rays: &[(UVec2, Ray3d, f32)]) -> f32 {
    let edge: Vec<_> = rays
        .iter()
        .filter(|(_, ray, _)| {
            let at = ray.get_point((WALL_AT - ray.origin.z) / ray.direction.z);
            (-2.1..-1.8).contains(&at.x) && (0.75..1.35).contains(&(at.y / WALL.y))
        })
        .collect();
    let rows = edge.chunk_by(|a, b| a.0.y == b.0.y);
    errors(rows.flat_map(|row| {
        let mean = row.iter().map(|(.., light)| light).sum::<f32>() / row.len() as f32;
        row.iter().map(move |(.., light)| light - mean)
    }))
    .0
}

/// A wall does not shine through the outlines of what is in front of it, no dots are along them, and its own edge is not hatched.
#[test]
fn outlines_in_glossy_floors_are_clean() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        for (roughness, most_hatched) in [(0.0, 0.01), (0.12, 0.01), (0.18, 0.005)] {
            let seen = things_before_a_wall(&mut headless, roughness);
            seen.save(&format!("outlines_{roughness}"), 1.0);
            let rays = floor_rays(&seen);
            let [dark, bright] = [(DARK_BALL, 0.6), (BRIGHT_BALL, 0.95)]
                .map(|(ball, share)| ball_light(&rays, ball, share));
            let brightest = dark.iter().copied().fold(0.0, f32::max);
            let specks = bright.iter().filter(|light| **light < 1.5).count();
            let rim = rim_light(&rays).into_iter().fold(0.0, f32::max);
            let hatched = hatching(&rays);
            println!(
                "{roughness}: dark ball {brightest:.3}, {specks} specks in the bright one, {} and {} pixels; rim \
                 {rim:.3}, hatching {hatched:.4}",
                dark.len(),
                bright.len()
            );
            assert!(brightest < 0.1 && specks < 10 && rim < 0.06 && hatched < most_hatched);
        }
    });
}
