//! Shares of the pyramid's levels, and the profile itself.

use bevy::math::{Vec2, Vec3};

/// Radius in mean free paths within which all light is assumed to leave.
pub const REACH: f32 = 10.0;
/// Smallest mean free path in pixels that is divided by.
pub const SHORTEST: f32 = 1e-4;

/// Logarithm, less than 0, of the share of light that levels from `level` on spread, for mean free paths of `paths` pixels. `level`
/// is at least 1. Level 1 has factors of its own; the kernels of the others all have one shape.
///
/// Fitted to the light that leaves beside an edge, for all positions of the edge within a texel, and paths of 0.5 to 20 pixels.
pub fn log_share_from(level: f32, paths: Vec3) -> Vec3 {
    let texels = level.exp2() / paths.max(Vec3::splat(SHORTEST));
    let factors = if level < 1.5 {
        Vec2::new(0.1223, 0.00219)
    } else {
        Vec2::new(0.2081, 0.00625)
    };
    -texels * (factors.x + factors.y * texels)
}

/// Share of the light in a level that is passed on to coarser ones.
pub fn share_beyond(level: f32, paths: Vec3) -> Vec3 {
    let mut share = log_share_from(level + 1.0, paths);
    if level >= 1.0 {
        share -= log_share_from(level, paths);
    }
    share.min(Vec3::ZERO).map(f32::exp)
}

/// Share of light that leaves within `paths_away` mean free paths of a line, on both sides: the mean of the share within a radius,
/// over the angles at which a circle meets the line.
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
