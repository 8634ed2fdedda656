//! Outlines in glossy mirrors: of things before a bright wall, and of the wall itself.

use core::ops::Range;

use bevy::{math::bounding::*, prelude::*};
use kit::{
    analytic_light::{Seen, camera, errors, surface},
    analytic_mirrors::metal,
    headless::Headless,
    own_process::in_own_process,
};

use super::scenes::{EYE, looking, mirror_ray, range, reflections, show_next, spawn_floor};

const SIZE: UVec2 = UVec2::new(480, 270);
const BALL: f32 = 0.12;
const DARK_BALL: Vec3 = Vec3::new(-0.8, 0.3, -0.4);
const BRIGHT_BALL: Vec3 = Vec3::new(0.0, 0.3, -0.4);
const PILLAR: Vec3 = Vec3::new(0.15, 1.0, 0.12);
/// Places of the pillars.
const PILLARS: [Vec3; 2] = [Vec3::new(-1.2, 0.5, -0.8), Vec3::new(0.4, 0.5, -0.8)];
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
        for at in PILLARS {
            let pillar = Cuboid::from_size(PILLAR);
            s.mesh(pillar, surface(0.0, 0.0), Transform::from_translation(at));
        }
        for (at, light) in [(DARK_BALL, 0.0), (BRIGHT_BALL, 3.0)] {
            let ball = Sphere::new(BALL).mesh().uv(32, 18);
            s.mesh(ball, surface(0.0, light), Transform::from_translation(at));
        }
        camera(s, looking(EYE, 0.3), 0.0, reflections());
    })
}

/// A pixel of the floor.
struct FloorPixel {
    pixel: UVec2,
    /// That it mirrors.
    ray: Ray3d,
    light: f32,
}

impl FloorPixel {
    /// Place of the ray in a plane that faces the camera.
    fn at(&self, z: f32) -> Vec3 {
        let away = (z - self.ray.origin.z) / self.ray.direction.z;
        self.ray.get_point(away)
    }

    /// Height at which the ray meets the front of the wall, as a share of the wall's.
    fn share_of_wall(&self) -> f32 {
        self.at(WALL_AT).y / WALL.y
    }

    /// True if the ray meets the front of the wall, between these shares of its height, where nothing else is close.
    fn is_beside_things(&self, heights: Range<f32>) -> bool {
        (-2.1..-1.8).contains(&self.at(WALL_AT).x) && heights.contains(&self.share_of_wall())
    }

    fn hits(&self, ball: Vec3, radius: f32) -> bool {
        let cast = RayCast3d::from_ray(self.ray, 10.0);
        let sphere = BoundingSphere::new(ball, radius);
        cast.sphere_intersection_at(&sphere).is_some()
    }

    /// True if the ray passes over the wall, but hits a pillar, or passes close to it.
    fn is_at_a_pillar(&self) -> bool {
        let pillar = PILLARS.into_iter().any(|pillar| {
            let beside = self.at(pillar.z);
            (beside.x - pillar.x).abs() < PILLAR.x && beside.y < PILLAR.y
        });
        pillar && self.share_of_wall() > 1.25
    }
}

fn floor_pixels(seen: &Seen) -> Vec<FloorPixel> {
    seen.on_plane(Vec3::ZERO, Vec3::Y)
        .filter_map(|(pixel, place, light)| {
            let ray = mirror_ray(EYE, place)?;
            Some(FloorPixel { pixel, ray, light })
        })
        .collect()
}

/// Light of at least `least` pixels.
fn light_of(pixels: &[FloorPixel], least: usize, are: impl Fn(&FloorPixel) -> bool) -> Vec<f32> {
    let light: Vec<_> = pixels
        .iter()
        .filter(|pixel| are(pixel))
        .map(|pixel| pixel.light)
        .collect();
    assert!(light.len() > least, "{} pixels", light.len());
    light
}

/// Difference of the image of the wall's upper edge from its mean along each row of pixels (RMS).
fn hatching(pixels: &[FloorPixel]) -> f32 {
    let edge: Vec<_> = pixels
        .iter()
        .filter(|pixel| pixel.is_beside_things(0.75..1.35))
        .collect();
    assert!(edge.len() > 500, "{} pixels", edge.len());
    let rows = edge.chunk_by(|a, b| a.pixel.y == b.pixel.y);
    let off = rows.flat_map(|row| {
        let mean = row.iter().map(|pixel| pixel.light).sum::<f32>() / row.len() as f32;
        row.iter().map(move |pixel| pixel.light - mean)
    });
    errors(off).0
}

/// A wall does not shine through the outlines of what is in front of it, no dots are along them, and its own edge is not hatched.
#[test]
fn outlines_in_glossy_floors_are_clean() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        for (roughness, most_hatched) in [(0.0, 0.001), (0.12, 0.0107), (0.18, 0.0042)] {
            let seen = things_before_a_wall(&mut headless, roughness);
            seen.save(&format!("outlines_{roughness}"), 1.0);
            let pixels = floor_pixels(&seen);
            let wall = light_of(&pixels, 500, |pixel| pixel.is_beside_things(0.2..0.7));
            let wall = wall.iter().sum::<f32>() / wall.len() as f32;
            let dark = range(&light_of(&pixels, 100, |p| p.hits(DARK_BALL, 0.6 * BALL))).1;
            let bright = light_of(&pixels, 250, |p| p.hits(BRIGHT_BALL, 0.95 * BALL));
            let specks = bright.iter().filter(|light| **light < 1.5).count();
            let rim = range(&light_of(&pixels, 150, FloorPixel::is_at_a_pillar)).1;
            let hatched = hatching(&pixels);
            println!(
                "{roughness}: wall {wall:.3}, dark ball {dark:.3}, {specks} specks in the bright one, rim \
                 {rim:.3}, hatching {hatched:.4}"
            );
            assert!(wall > 0.9 && dark < 0.1 && specks < 10);
            assert!(rim < 0.06 && hatched < most_hatched);
        }
    });
}
