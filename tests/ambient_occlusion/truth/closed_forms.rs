//! Each closed form against an independent Monte Carlo integral, and its limits.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use bevy::math::{DVec2, DVec3};

use super::directions::{cosine_weighted, uniform, uniform_in_angle};
use kit::occlusion::closed_forms::*;

const INF: f64 = f64::INFINITY;
/// Rows of jittered samples.
const ROWS: u32 = 400;
/// Largest difference seen: 1.4e-4. As many independent samples would have a standard error of up to 1.2e-3.
const TOLERANCE: f64 = 2.5e-4;

/// Compares a closed form with the share of `directions` about Z that are occluded.
#[track_caller]
fn check_in(
    directions: impl Iterator<Item = DVec3>,
    expected: f64,
    occluded: impl Fn(DVec3) -> bool,
) {
    let share = directions.filter(|d| occluded(*d)).count() as f64 / f64::from(ROWS * ROWS);
    println!("{expected:.6} {:+.1e}", share - expected);
    assert!(
        (share - expected).abs() < TOLERANCE,
        "closed form {expected:.6}, Monte Carlo {share:.6}"
    );
}

#[track_caller]
fn check(expected: f64, occluded: impl Fn(DVec3) -> bool) {
    check_in(cosine_weighted(1, ROWS), expected, occluded);
}

#[track_caller]
fn same(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} and {b}");
}

/// Distance to the plane at `distance` along a unit axis, on which the ray's direction has `component`.
fn to_plane(distance: f64, component: f64) -> f64 {
    if component > 0.0 {
        distance / component
    } else {
        INF
    }
}

/// True if a ray hits a wall at x = `distance`.
fn hits_wall(d: DVec3, distance: f64, height: f64, radius: f64) -> bool {
    let t = to_plane(distance, d.x);
    t < INF && t <= radius && t * d.z <= height
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn walls() {
    for (distance, height, radius) in [
        (0.5, 1.0, INF),
        (0.1, 1.0, INF),
        (2.0, 1.0, INF),
        (0.25, 5.0, 0.7285),
        (0.5, INF, 0.7285),
        (0.25, 0.3, 0.7285),
        (0.1, 0.2, 0.5),
        (0.6, 0.2, 1.0),
    ] {
        let expected = wall(distance, height, radius);
        check(expected, |d| hits_wall(d, distance, height, radius));
        same(
            expected,
            2.0 * wall_sector(distance, height, radius, FRAC_PI_2),
        );
        for azimuth in [0.4, 1.2] {
            check(wall_sector(distance, height, radius, azimuth), |d| {
                (0.0..azimuth).contains(&d.y.atan2(d.x)) && hits_wall(d, distance, height, radius)
            });
        }
        check_in(
            uniform_in_angle(1, ROWS),
            wall_by_slice_angle(distance, height, radius),
            |d| hits_wall(d, distance, height, radius),
        );
    }
    for (distance, height, width) in [(0.5, 1.0, 0.7), (1.0, 1.0, 1.0), (0.2, 2.0, 0.3)] {
        let expected = rectangular_wall(distance, height, width);
        check(expected, |d| {
            let y = to_plane(distance, d.x) * d.y;
            hits_wall(d, distance, height, INF) && (0.0..=width).contains(&y)
        });
        let azimuth = f64::atan2(width, distance);
        same(expected, wall_sector(distance, height, INF, azimuth));
    }
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn walls_by_other_weights() {
    for (distance, height) in [(0.5, 1.0), (0.1, 1.0), (2.0, 1.0)] {
        check_in(
            uniform(1, ROWS),
            wall_by_solid_angle(distance, height),
            |d| hits_wall(d, distance, height, INF),
        );
    }
    for (distance, radius) in [(0.2, 1.0), (0.5, 0.7285), (2.0, 1.0)] {
        check_in(
            uniform(1, ROWS),
            tall_wall_by_solid_angle(distance, radius),
            |d| hits_wall(d, distance, INF, radius),
        );
    }
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn wall_limits() {
    // At the foot of the wall, far from it, in front of a wall of no height, at the radius, and with the top beyond the radius.
    same(wall(0.0, 1.0, 1.0), 0.5);
    same(wall(1e9, 1.0, INF), 0.0);
    same(wall(0.3, 0.0, 1.0), 0.0);
    same(wall(1.0, 1.0, 1.0), 0.0);
    same(wall(0.3, 2.0, 1.0), wall(0.3, INF, 1.0));
    same(wall(0.3, INF, INF), 0.5);
    same(wall(0.3, 0.4, INF), 0.5 * (1.0 - 0.6));
    same(wall(0.3, 0.4, 1e9), wall(0.3, 0.4, INF));
    same(rectangular_wall(0.3, 0.4, INF), 0.5 * wall(0.3, 0.4, INF));
    same(wall_sector(0.3, INF, INF, FRAC_PI_4), 0.125);
    same(wall_by_solid_angle(0.3, INF), 0.5);
    same(tall_wall_by_solid_angle(0.3, INF), 0.5);
    same(wall_by_slice_angle(0.3, INF, INF), 0.5);
}

/// True if a ray from (s, 0, 0) hits the face of a groove that rises from the origin at `interior_angle`.
fn hits_face(d: DVec3, interior_angle: f64, s: f64, length: f64, radius: f64) -> bool {
    let (sin, cos) = interior_angle.sin_cos();
    let t = to_plane(s * sin, d.z * cos - d.x * sin);
    let from_edge = (s + t * d.x) * cos + t * d.z * sin;
    t <= radius && (-1e-9..=length).contains(&from_edge)
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn v_grooves() {
    for degrees in [30.0, 60.0, 90.0, 120.0, 150.0] {
        let angle = f64::to_radians(degrees);
        check(v_groove(angle), |d| hits_face(d, angle, 1.0, 1e30, 1e30));
        same(v_groove_within(angle, 1.0, 1e12), v_groove(angle));
        same(v_groove_within(angle, 1.0, INF), v_groove(angle));
        same(v_groove_within(angle, 0.0, 1.0), v_groove(angle));
        same(v_groove_of_length(angle, 1.0, 1e12), v_groove(angle));
        same(v_groove_of_length(angle, 1.0, 0.0), 0.0);
    }
    for (degrees, s, length) in [(60.0, 0.5, 1.0), (90.0, 0.3, 1.0), (120.0, 1.5, 2.0)] {
        let angle = f64::to_radians(degrees);
        check(v_groove_of_length(angle, s, length), |d| {
            hits_face(d, angle, s, length, INF)
        });
    }
    for (degrees, s, radius) in [
        (60.0, 0.3, 0.7),
        (120.0, 0.3, 0.7),
        (90.0, 0.3, 0.7),
        (135.0, 0.5, 0.7285),
        (60.0, 0.7, 0.7),
        (30.0, 0.3, 1.0),
    ] {
        let angle = f64::to_radians(degrees);
        check(v_groove_within(angle, s, radius), |d| {
            hits_face(d, angle, s, INF, radius)
        });
    }
    same(v_groove_within(FRAC_PI_2, 0.3, 0.7), wall(0.3, INF, 0.7));
    same(v_groove(PI), 0.0);
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn tilted_planes() {
    for (angle, half_angle) in [
        (20.0, 40.0),
        (60.0, 20.0),
        (60.0, 50.0),
        (80.0, 45.0),
        (100.0, 60.0),
        (89.0, 10.0),
        (120.0, 50.0),
        (120.0, 20.0),
    ] {
        let (sin, cos) = f64::to_radians(angle).sin_cos();
        let distance = f64::to_radians(half_angle).cos();
        check(tilted_plane(f64::to_radians(angle), distance, 1.0), |d| {
            d.x * sin + d.z * cos >= distance
        });
    }
    // Straight in front of the point and straight behind it.
    same(tilted_plane(0.0, 0.6, 1.0), 0.64);
    same(tilted_plane(0.0, 0.6, INF), 1.0);
    same(tilted_plane(PI, 0.6, 1.0), 0.0);
    same(tilted_plane(1.0, 1.0, 1.0), 0.0);
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn spheres() {
    for (offset, height, r, radius) in [
        (1.0, 1.0, 1.0, INF),
        (0.3, 1.0, 1.0, INF),
        (2.0, 1.0, 1.0, INF),
        (1.0, 1.5, 1.0, INF),
        (0.5, 0.5, 0.5, 0.3),
        (1.0, 0.5, 0.5, 0.7285),
        (0.7, 0.5, 0.5, 0.5),
    ] {
        check(floor_under_sphere(r, height, offset, radius), |d| {
            let center = DVec3::new(offset, 0.0, height);
            let along = d.dot(center);
            let square = along * along - center.length_squared() + r * r;
            square >= 0.0 && along > 0.0 && along - square.sqrt() <= radius
        });
    }
    // At its point of contact, far away, and at the radius that just reaches its outline.
    same(floor_under_sphere(1.0, 1.0, 0.0, INF), 1.0);
    same(floor_under_sphere(1.0, 1.0, 1e9, INF), 0.0);
    same(
        floor_under_sphere(1.0, 1.0, 2.0, 2.0),
        floor_under_sphere(1.0, 1.0, 2.0, INF),
    );
    same(floor_under_sphere(1.0, 2.0, 0.0, 1.0), 0.0);
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn box_corners() {
    let hits = |d: DVec3, a, b, height, radius| {
        hits_wall(d, a, height, radius) || hits_wall(d.with_x(d.y), b, height, radius)
    };
    for (a, b, height) in [(0.5, 0.5, 1.0), (0.2, 1.0, 0.7), (1.0, 2.0, 0.5)] {
        let expected = box_corner(a, b, height);
        check(expected, |d| hits(d, a, b, height, INF));
        same(expected, box_corner_within(a, b, height, INF));
        for radius in [0.4, 0.9, 1.5] {
            check(box_corner_within(a, b, height, radius), |d| {
                hits(d, a, b, height, radius)
            });
            check(box_corner_within(a, b, INF, radius), |d| {
                hits(d, a, b, INF, radius)
            });
        }
    }
    same(box_corner(0.3, 1e12, 0.4), wall(0.3, 0.4, INF));
    same(box_corner_within(0.3, 0.4, INF, INF), 0.75);
    // The walls meet just beyond the radius.
    same(
        box_corner_within(0.3, 0.4, INF, 0.5),
        wall(0.3, INF, 0.5) + wall(0.4, INF, 0.5),
    );
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn pits() {
    for (offset, pit_radius, depth) in [(0.0, 1.0, 1.0), (0.5, 1.0, 1.0), (0.8, 1.0, 0.5)] {
        let expected = pit(pit_radius, depth, offset);
        check(expected, |d| {
            let at_top = DVec2::new(offset, 0.0) + d.truncate() * (depth / d.z);
            at_top.length() > pit_radius
        });
        assert!((expected - pit_within(pit_radius, depth, offset, INF)).abs() < 1e-6);
        for radius in [0.3, 0.9, 1.5] {
            check(pit_within(pit_radius, depth, offset, radius), |d| {
                let (start, d2) = (DVec2::new(offset, 0.0), d.truncate());
                let (a, b) = (d2.length_squared(), start.dot(d2));
                let c = start.length_squared() - pit_radius * pit_radius;
                let t = ((b * b - a * c).sqrt() - b) / a;
                t <= radius && t * d.z <= depth
            });
        }
    }
    same(pit(1.0, 0.5, 0.0), 1.0 - 1.0 / 1.25);
    same(pit(1.0, 1e9, 0.3), 1.0);
    same(pit(1.0, 0.0, 0.3), 0.0);
    // A wide pit is a wall.
    assert!((pit(1e6, 1.0, 1e6 - 0.5) - wall(0.5, 1.0, INF)).abs() < 1e-5);
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn trenches() {
    for (from_side, width, depth) in [(0.5, 1.0, 1.0), (0.2, 1.0, 0.5)] {
        let expected = trench(width, depth, from_side);
        check(expected, |d| {
            let at_top = from_side + depth * d.x / d.z;
            !(0.0..=width).contains(&at_top)
        });
        same(expected, trench_within(width, depth, from_side, INF));
        for radius in [0.4, 1.0] {
            check(trench_within(width, depth, from_side, radius), |d| {
                hits_wall(d, width - from_side, depth, radius)
                    || hits_wall(d.with_x(-d.x), from_side, depth, radius)
            });
        }
    }
    same(trench(1.0, 0.0, 0.3), 0.0);
    same(trench(1.0, 1e12, 0.3), 1.0);
}
