// Burley's normalised diffusion (Christensen and Burley 2015, "Approximate Reflectance Profiles for Efficient Subsurface
// Scattering"), R(r) = (exp(-r / d) + exp(-r / 3d)) / (8π d r), as a mixture of the kernels of a pyramid.
#define_import_path bevy_lean_deferred::effects::subsurface::profile

/// Radius in mean free paths within which all light counts as having left.
const REACH: f32 = 10.0;
/// Lower bound of path lengths in pixels, to divide by.
const SHORTEST: f32 = 1e-4;

/// Logarithm, below 0, of the share of light that levels from this one on spread, for `paths` in pixels. `level` is at least 1. Level
/// 1 has factors of its own; the kernels of the others are all of one shape.
fn log_share_from(level: f32, paths: vec3<f32>) -> vec3<f32> {
    let texels = exp2(level) / max(paths, vec3(SHORTEST));
    let factors = select(vec2(0.2081, 0.00625), vec2(0.1223, 0.00219), level < 1.5);
    return -texels * (factors.x + factors.y * texels);
}

/// Share of the light reaching a level that goes on to coarser ones.
fn share_beyond(level: f32, paths: vec3<f32>) -> vec3<f32> {
    var share = log_share_from(level + 1.0, paths);
    if level >= 1.0 {
        share -= log_share_from(level, paths);
    }
    return exp(min(share, vec3(0.0)));
}
