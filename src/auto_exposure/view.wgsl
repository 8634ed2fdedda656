// What the passes of auto exposure know of a view, and what they leave for one another.
#define_import_path bevy_lean_deferred::auto_exposure::view

/// Pixels that a workgroup reads if it reads all; twin of `TILE` in `key.rs`.
const TILE: vec2<u32> = vec2(64u, 128u);

/// Twin of the struct of the same name in `uniforms.rs`.
struct ExposureView {
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    seconds: f32,
    /// Base-2 logarithm of the luminance to be reached.
    log_target: f32,
    compensation: f32,
    min_exposure: f32,
    max_exposure: f32,
    speed_brighten: f32,
    speed_darken: f32,
    transition: f32,
    /// Shares of the weight that are left out.
    trim_low: f32,
    trim_high: f32,
    /// Of the metered disc, as a share of the viewport's height.
    spot_radius: f32,
    instant: u32,
    /// Counts camera cuts.
    cuts: u32,
    curve_points: u32,
    /// (metered logarithm, stops) in each.
    curve: array<vec4<f32>, 16>,
}

/// Kept from frame to frame, and read back. Twin of the struct of the same name in `uniforms.rs`.
struct ExposureState {
    luminance: f32,
    exposure: f32,
    target_exposure: f32,
    /// Camera cuts seen, plus one; 0 before the first frame.
    cuts_seen: u32,
}

/// Bins of the histogram, over the logarithms -14 to 16.
const BINS: u32 = 256u;
const LOG_OF_FIRST_BIN: f32 = -14.0;
const BINS_PER_STOP: f32 = 8.5333333;
/// A full weight, in the histogram's counts: 8192×8192 pixels do not overflow a bin.
const FULL_WEIGHT: f32 = 63.0;
