// Burley's normalised diffusion (Christensen and Burley 2015, "Approximate Reflectance Profiles for Efficient Subsurface
// Scattering"): R(r) = (exp(-r / d) + exp(-r / 3d)) / (8π d r). Twin of `profile.rs`, under the same names.
#define_import_path bevy_lean_deferred::screen_space::subsurface::profile

const PI: f32 = 3.14159265358979;

/// Mean free paths within which all light counts as having left: 97% of it.
const REACH: f32 = 10.0;
/// Paths too short to divide by.
const SHORTEST: f32 = 1e-7;

/// The radius, in mean free paths, within which a share of the light leaves, 0 to less than 1.
fn radius_of(share: f32) -> f32 {
    // With y = exp(-r / 3d) the share is 1 - y³ / 4 - 3y / 4.
    let half = 2.0 * (1.0 - share);
    let root = pow(half + sqrt(half * half + 1.0), 1.0 / 3.0);
    return -3.0 * log(root - 1.0 / root);
}

/// 8π r times the profile of each channel, by its path.
fn falloff(radius: f32, paths: vec3<f32>) -> vec3<f32> {
    let far = exp(-radius / (3.0 * paths));
    return (far * far * far + far) / paths;
}

/// A sample, for channels with these paths: from the profile of one of them.
struct Sample {
    radius: f32,
    /// What its light counts for, over how often such samples are taken.
    weights: vec3<f32>,
    /// The part of the surface that it stands for, times how many samples there are.
    area: f32,
}

/// Of the profile of channel `channel`, at a share of its light.
fn sample_of(paths: vec3<f32>, channel: u32, share: f32) -> Sample {
    let valid = max(paths, vec3(SHORTEST));
    let radius = max(radius_of(share), 1e-6) * valid[channel];
    let each = falloff(radius, valid);
    let mean = max((each.r + each.g + each.b) / 3.0, 1e-30);
    return Sample(radius, each / mean, 8.0 * PI * radius / mean);
}

/// The share of light that leaves within so many mean free paths of a line, over both of its sides.
fn share_beside(paths_away: f32) -> f32 {
    var shares = array<f32, 33>(
        0.00000, 0.02280, 0.07052, 0.13149, 0.19961, 0.27082, 0.34221, 0.41174, 0.47796, 0.53994, 0.59714,
        0.64930, 0.69640, 0.73859, 0.77610, 0.80924, 0.83835, 0.86376, 0.88583, 0.90488, 0.92123, 0.93518,
        0.94700, 0.95695, 0.96526, 0.97216, 0.97785, 0.98249, 0.98626, 0.98930, 0.99172, 0.99364, 0.99515,
    );
    let at = 32.0 * sqrt(saturate(paths_away / 12.0));
    let first = u32(min(at, 31.0));
    return mix(shares[first], shares[first + 1u], at - f32(first));
}
