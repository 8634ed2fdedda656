//! Random directions over a hemisphere.

use std::f64::consts::TAU;

use bevy::math::{DVec2, DVec3};
use kit::random::Random;

/// `rows`² points in the unit square, one in each cell of a grid: for a region with a smooth boundary the error of
/// their share is near `rows`^-1.5, far below that of as many independent points.
fn jittered_points(seed: u64, rows: u32) -> impl Iterator<Item = DVec2> {
    let mut random = Random::new(seed);
    (0..rows * rows).map(move |i| {
        let cell = DVec2::new((i % rows).into(), (i / rows).into());
        let jitter = DVec2::new(random.unit().into(), random.unit().into());
        (cell + jitter) / f64::from(rows)
    })
}

fn direction(azimuth: f64, z: f64) -> DVec3 {
    let (sin, cos) = (TAU * azimuth).sin_cos();
    (DVec2::new(cos, sin) * (1.0 - z * z).max(0.0).sqrt()).extend(z)
}

/// Directions about Z with cosine-weighted density (Malley's method).
pub fn cosine_weighted(seed: u64, rows: u32) -> impl Iterator<Item = DVec3> {
    jittered_points(seed, rows).map(|point| direction(point.x, (1.0 - point.y).sqrt()))
}
