// Burley's normalised diffusion (Christensen and Burley 2015, "Approximate Reflectance Profiles for Efficient Subsurface
// Scattering"), R(r) = (exp(-r / d) + exp(-r / 3d)) / (8π d r), as a mixture of the kernels that a pyramid has.
#define_import_path bevy_lean_deferred::screen_space::subsurface::profile

/// Mean free paths within which light counts as having left.
const REACH: f32 = 10.0;
/// Pixels that are too few to divide by.
const SHORTEST: f32 = 1e-4;

/// The logarithm of the share of light, less than 0, that levels from this one on spread, of paths so many pixels long. The
/// level is 1 at least: it has less of it than would follow from the others, whose kernels are all of one shape.
fn log_share_from(level: f32, paths: vec3<f32>) -> vec3<f32> {
    let texels = exp2(level) / max(paths, vec3(SHORTEST));
    let factors = select(vec2(0.2081, 0.00625), vec2(0.1223, 0.00219), level < 1.5);
    return -texels * (factors.x + factors.y * texels);
}

/// The share of what reaches a level that goes on to coarser ones.
fn share_beyond(level: f32, paths: vec3<f32>) -> vec3<f32> {
    var share = log_share_from(level + 1.0, paths);
    if level >= 1.0 {
        share -= log_share_from(level, paths);
    }
    return exp(min(share, vec3(0.0)));
}
