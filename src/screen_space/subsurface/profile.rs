//! Twin of `profile.wgsl`, under the same names.

use core::f32::consts::PI;

use bevy::math::Vec3;

/// Mean free paths within which all light counts as having left: 97% of it.
pub const REACH: f32 = 10.0;
const SHORTEST: f32 = 1e-7;

/// The radius, in mean free paths, within which a share of the light leaves, 0 to less than 1.
pub fn radius_of(share: f32) -> f32 {
    let half = 2.0 * (1.0 - share);
    let root = (half + (half * half + 1.0).sqrt()).powf(1.0 / 3.0);
    -3.0 * (root - 1.0 / root).ln()
}

/// 8π r times the profile of each channel, by its path.
pub fn falloff(radius: f32, paths: Vec3) -> Vec3 {
    let far = (-radius / (3.0 * paths)).map(f32::exp);
    (far * far * far + far) / paths
}

/// A sample, for channels with these paths: from the profile of one of them.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    pub radius: f32,
    /// What its light counts for, over how often such samples are taken.
    pub weights: Vec3,
    /// The part of the surface that it stands for, times how many samples there are.
    pub area: f32,
}

/// Of the profile of channel `channel`, at a share of its light.
pub fn sample_of(paths: Vec3, channel: usize, share: f32) -> Sample {
    let valid = paths.max(Vec3::splat(SHORTEST));
    let radius = radius_of(share).max(1e-6) * valid[channel];
    let each = falloff(radius, valid);
    let mean = (each.element_sum() / 3.0).max(1e-30);
    Sample {
        radius,
        weights: each / mean,
        area: 8.0 * PI * radius / mean,
    }
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
