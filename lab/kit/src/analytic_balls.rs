//! Balls with subsurface scattering of a known profile, as in a row of the example `materials`.

use bevy::{
    math::bounding::{BoundingSphere, RayCast3d},
    mesh::VertexAttributeValues,
    prelude::*,
};
use bevy_lean_deferred::prelude::ExtendedStandardMaterial;
use core::f32::consts::PI;

use crate::{
    analytic_light::{Errors, Seen, camera, show},
    analytic_slabs::{slab, stored_paths},
};

/// Radius of a ball, in metres.
pub const RADIUS: f32 = 0.4;

/// Light that enters at a surface with this normal, from a distant lamp to the left above the camera.
fn entering(normal: Vec3) -> f32 {
    normal.dot(Vec3::new(-0.8, 0.36, 0.48)).max(0.0)
}

/// Burley's profile by distance in metres, without the factor 1 / 8πd, which cancels in normalised sums.
fn profile(distance: f32, path: f32) -> f32 {
    ((-distance / path).exp() + (-distance / (3.0 * path)).exp()) / distance
}

/// Light that leaves at this normal: the mean of the light entering all over the ball, weighted by the profile of the chord length.
fn leaving(normal: Vec3, path: f32) -> f32 {
    let (across, up) = normal.any_orthonormal_pair();
    let (radii, turns) = (96, 24);
    let (mut sum, mut weights) = (0.0, 0.0);
    for i in 0..radii {
        // Samples are denser where the profile is steep.
        let share = (i as f32 + 0.5) / radii as f32;
        let angle = PI * share * share;
        let weight = profile(2.0 * RADIUS * (angle / 2.0).sin(), path) * angle.sin() * share;
        let light: f32 = (0..turns)
            .map(|turn| {
                let direction = Vec2::from_angle(2.0 * PI * (turn as f32 + 0.5) / turns as f32);
                let away = across * direction.x + up * direction.y;
                entering(normal * angle.cos() + away * angle.sin())
            })
            .sum();
        sum += weight * light / turns as f32;
        weights += weight;
    }
    sum / weights
}

/// A pixel that shows the ball.
struct Spot {
    index: usize,
    normal: Vec3,
    /// Area of the ball that it shows, in square metres.
    area: f32,
}

/// Light that leaves at `spot`, of the light entering at the picture's pixels: the best that screen space allows.
fn leaving_of_seen(spot: &Spot, spots: &[Spot], path: f32) -> f32 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for other in spots {
        let distance = RADIUS * spot.normal.distance(other.normal);
        let weight = if other.index == spot.index {
            // Integral of the profile over a disc of the pixel's area.
            let radius = (other.area / PI).sqrt();
            let beyond = (-radius / path).exp() + 3.0 * (-radius / (3.0 * path)).exp();
            2.0 * PI * path * (4.0 - beyond)
        } else {
            profile(distance, path) * other.area
        };
        sum += weight * entering(other.normal);
        weights += weight;
    }
    sum / weights
}

/// Errors of a picture of a ball, per channel.
#[derive(Clone, Copy, Debug)]
pub struct BallErrors {
    /// Against the light that leaves the whole ball.
    pub truth: Errors,
    /// Against the best that screen space allows, with every pixel sampled.
    pub picture: Errors,
    /// The best that screen space allows, against the light that leaves the whole ball.
    pub method: Errors,
}

fn spots(seen: &Seen) -> Vec<Spot> {
    let ball = BoundingSphere::new(Vec3::ZERO, RADIUS);
    let pixel_angle = {
        let middle = seen.rays().len() / 2 + seen.light.size.x as usize / 2;
        let [a, b] = [0, 1].map(|i| seen.rays()[middle + i].direction);
        a.angle_between(*b)
    };
    let rays = seen.rays().iter().enumerate();
    rays.filter_map(|(index, ray)| {
        let distance = RayCast3d::from_ray(*ray, f32::MAX).sphere_intersection_at(&ball)?;
        let normal = ray.get_point(distance).normalize();
        let faces = -normal.dot(*ray.direction);
        // Skips the outline, which only covers its pixels in part.
        (faces > 0.1).then(|| Spot {
            index,
            normal,
            area: (distance * pixel_angle).powi(2) / faces,
        })
    })
    .collect()
}

/// Errors of a ball seen from the front; `color` scales the scattering distance `path`, in metres, per channel.
pub fn ball(size: UVec2, color: LinearRgba, path: f32, effect: impl Bundle) -> [BallErrors; 3] {
    let (_, seen) = show(size, 2, |s| {
        let mut mesh = Sphere::new(RADIUS).mesh().uv(256, 128);
        let Some(VertexAttributeValues::Float32x3(normals)) =
            mesh.attribute(Mesh::ATTRIBUTE_NORMAL)
        else {
            unreachable!("spheres have normals");
        };
        let colors: Vec<_> = normals
            .iter()
            .map(|normal| {
                let light = entering(Vec3::from(*normal));
                [light, light, light, 1.0]
            })
            .collect();
        mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
        let mesh = s.add::<Mesh>(mesh);
        let material = s.add::<ExtendedStandardMaterial>(slab(color, path));
        s.world().spawn((Mesh3d(mesh), MeshMaterial3d(material)));
        camera(s, Transform::from_xyz(0.0, 0.0, 1.2), 1.0, effect);
    });
    seen.save(&format!("ball_{path}"), 0.9);
    let spots = spots(&seen);
    let paths = stored_paths(color, path);
    [0, 1, 2].map(|channel| {
        let path = paths[channel];
        // Checks one pixel in 25.
        let width = seen.light.size.x as usize;
        let asked = spots.iter().filter(|spot| {
            let [x, y] = [spot.index % width, spot.index / width];
            x.is_multiple_of(5) && y.is_multiple_of(5)
        });
        let found: Vec<[f32; 3]> = asked
            .map(|spot| {
                [
                    seen.light.texels[spot.index][channel],
                    leaving(spot.normal, path),
                    leaving_of_seen(spot, &spots, path),
                ]
            })
            .collect();
        let errors = |a: usize, b: usize| Errors::of(found.iter().map(|x| x[a] - x[b]));
        BallErrors {
            truth: errors(0, 1),
            picture: errors(0, 2),
            method: errors(2, 1),
        }
    })
}
