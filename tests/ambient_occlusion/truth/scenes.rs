//! The closed form of each scene at visible points, against a Monte Carlo integral of the scene's own rays.

use std::f64::consts::PI;

use bevy::math::{DVec3, UVec2};

use super::{
    camera::{PERSPECTIVE, camera},
    directions::cosine_weighted,
};
use kit::occlusion::{
    depth_buffer::DepthBuffer,
    geometry::{Geometry, Scene},
};

/// Rows of jittered samples.
const ROWS: u32 = 192;
/// Largest difference seen: 5.7e-4. As many independent samples would have a standard error of up to 2.6e-3.
const TOLERANCE: f64 = 1e-3;

/// Every geometry, with an eye and a target that show each of its faces.
fn views() -> Vec<(Geometry, DVec3, DVec3)> {
    let v = DVec3::new;
    vec![
        (
            Geometry::Plane {
                point: v(0.1, 0.2, 0.3),
                normal: v(1.0, 2.0, 3.0),
            },
            v(0.0, 2.0, 4.0),
            v(0.0, 0.0, 0.0),
        ),
        (
            Geometry::Wall { height: 1.0 },
            v(2.0, 3.0, 2.0),
            v(0.1, 0.6, 0.0),
        ),
        (
            Geometry::Wall {
                height: f64::INFINITY,
            },
            v(3.0, 2.0, 2.0),
            v(0.1, 0.2, 0.0),
        ),
        (
            Geometry::Groove {
                interior_angle: PI / 3.0,
            },
            v(0.3, 3.0, 1.0),
            v(0.0, 0.5, 0.0),
        ),
        (
            Geometry::Groove {
                interior_angle: 0.7 * PI,
            },
            v(0.3, 3.0, 1.0),
            v(0.0, 0.0, 0.0),
        ),
        (
            Geometry::Corner { height: 1.0 },
            v(2.5, 3.0, 2.0),
            v(0.2, 0.6, 0.2),
        ),
        (
            Geometry::Corner {
                height: f64::INFINITY,
            },
            v(2.5, 2.0, 2.0),
            v(0.1, 0.2, 0.1),
        ),
        (
            Geometry::Pit {
                pit_radius: 1.0,
                depth: 0.6,
            },
            v(0.2, 3.5, 1.0),
            v(0.0, 0.0, 0.0),
        ),
        (
            Geometry::Trench {
                width: 1.5,
                depth: 0.7,
            },
            v(0.1, 3.0, 1.0),
            v(0.0, 0.2, 0.0),
        ),
        (
            Geometry::Sphere {
                sphere_radius: 0.5,
                height: 0.6,
            },
            v(0.0, 1.0, 3.0),
            v(0.0, 0.4, 0.0),
        ),
        (
            Geometry::Pole {
                thickness: 0.1,
                gap: 1.0,
            },
            v(0.3, 0.5, 1.5),
            v(0.0, 0.0, 0.0),
        ),
        (
            Geometry::FacetedCylinder {
                cylinder_radius: 1.0,
                facets: 7,
            },
            v(0.3, 0.5, 3.0),
            v(0.0, 0.0, 0.0),
        ),
        (
            Geometry::Staircase {
                tread: 0.4,
                riser: 0.25,
                steps: 4,
            },
            v(-1.5, 2.0, 1.0),
            v(0.6, 0.4, 0.0),
        ),
    ]
}

/// The share of cosine-weighted rays about the normal that hit the scene within the radius.
fn monte_carlo(scene: &Scene, point: DVec3, normal: DVec3, radius: f64, seed: u64) -> f64 {
    // Off the surface, so that rays do not start within it.
    let origin = point + normal * 1e-9;
    let (x, y) = normal.any_orthonormal_pair();
    let hits = cosine_weighted(seed, ROWS).filter(|d| {
        let direction = x * d.x + y * d.y + normal * d.z;
        scene
            .hit(origin, direction)
            .is_some_and(|hit| hit.distance <= radius)
    });
    hits.count() as f64 / f64::from(ROWS * ROWS)
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn scenes_have_the_occlusion_they_claim() {
    let size = UVec2::new(17, 13);
    let mut largest = 0.0f64;
    for (geometry, eye, target) in views() {
        let scene = Scene::new(geometry);
        let buffer = DepthBuffer::new(camera(eye, target, PERSPECTIVE, size), &scene);
        let mut compared = 0;
        for radius in [0.3, 0.7, f64::INFINITY] {
            for (i, hit) in buffer.hits.iter().enumerate().skip(3).step_by(9) {
                let Some(hit) = hit else { continue };
                let Some(truth) = scene.occlusion(hit, radius) else {
                    continue;
                };
                let found = monte_carlo(&scene, hit.point, hit.normal, radius, i as u64);
                largest = largest.max((found - truth).abs());
                assert!(
                    (found - truth).abs() < TOLERANCE,
                    "{geometry:?} at {} within {radius}: closed form {truth:.4}, Monte Carlo {found:.4}",
                    hit.point
                );
                compared += 1;
            }
        }
        assert!(compared >= 20, "{geometry:?}: {compared} points");
    }
    println!("largest difference {largest:.1e}");
}
