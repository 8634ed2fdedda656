//! The shares of a pyramid's levels, for tests, and the profile itself.

use bevy::math::{Vec2, Vec3};

/// Mean free paths within which light counts as having left.
pub const REACH: f32 = 10.0;
/// Pixels that are too few to divide by.
pub const SHORTEST: f32 = 1e-4;

/// The logarithm of the share of light, less than 0, that levels from this one on spread, of paths so many pixels long. The
/// level is 1 at least: it has less of it than would follow from the others, whose kernels are all of one shape.
///
/// Fitted to what leaves beside an edge, at all places of the edge among texels, for paths of 0.5 to 20 pixels.
pub fn log_share_from(level: f32, paths: Vec3) -> Vec3 {
    let texels = level.exp2() / paths.max(Vec3::splat(SHORTEST));
    let factors = if level < 1.5 {
        Vec2::new(0.1223, 0.00219)
    } else {
        Vec2::new(0.2081, 0.00625)
    };
    -texels * (factors.x + factors.y * texels)
}

/// The share of what reaches a level that goes on to coarser ones.
pub fn share_beyond(level: f32, paths: Vec3) -> Vec3 {
    let mut share = log_share_from(level + 1.0, paths);
    if level >= 1.0 {
        share -= log_share_from(level, paths);
    }
    share.min(Vec3::ZERO).map(f32::exp)
}

/// The share of light that leaves within so many mean free paths of a line, over both of its sides: the mean of the share
/// within a radius over the angles at which a circle meets the line.
pub fn share_beside(paths_away: f32) -> f32 {
    let angles = 4096;
    let sum: f64 = (0..angles)
        .map(|i| {
            let angle = (f64::from(i) + 0.5) / f64::from(angles) * core::f64::consts::FRAC_PI_2;
            let radius = f64::from(paths_away) / angle.cos();
            1.0 - 0.25 * (-radius).exp() - 0.75 * (-radius / 3.0).exp()
        })
        .sum();
    (sum / f64::from(angles)) as f32
}
