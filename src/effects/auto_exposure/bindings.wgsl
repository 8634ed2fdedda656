// Bindings of the auto exposure passes. Each pass imports those that it uses.
#define_import_path bevy_lean_deferred::effects::auto_exposure::bindings

#import bevy_render::view::View

/// Width in pixels of a workgroup's tile.
const TILE_WIDTH: u32 = 64u;

/// Settings and view data of the passes.
struct ExposureUniform {
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    seconds: f32,
    /// Base-2 logarithm of the target luminance.
    log_target: f32,
    compensation: f32,
    min_exposure: f32,
    max_exposure: f32,
    speed_brighten: f32,
    speed_darken: f32,
    transition: f32,
    /// Shares of the weight to trim.
    trim_low: f32,
    trim_high: f32,
    /// Radius of the metered disc, as a share of the viewport's height.
    spot_radius: f32,
    instant: u32,
    /// Number of camera cuts.
    cuts: u32,
    curve_points: u32,
    /// Height in pixels of a workgroup's tile: a multiple of 32.
    tile_height: u32,
    /// (metered logarithm, stops) per point.
    curve: array<vec4<f32>, 16>,
}

/// Kept across frames, and read back.
struct ExposureState {
    luminance: f32,
    exposure: f32,
    target_exposure: f32,
    /// Camera cuts seen, plus one; 0 before the first frame. With `AWAITS_LIGHT` until a frame since the cut shows light.
    cuts_seen: u32,
}

/// Flag in `cuts_seen`, above any number of cuts.
const AWAITS_LIGHT: u32 = 0x80000000u;

/// Bins of the histogram, over the base-2 logarithms -14 to 16.
const BINS: u32 = 256u;
const LOG_OF_FIRST_BIN: f32 = -14.0;
const BINS_PER_STOP: f32 = 8.5333333;
/// A full weight, in counts of the histogram: 8192×8192 pixels do not overflow a bin.
const FULL_WEIGHT: f32 = 63.0;

@group(0) @binding(0) var<uniform> view: ExposureUniform;
@group(0) @binding(1) var picture: texture_2d<f32>;
#ifdef HISTOGRAM
@group(0) @binding(2) var<storage, read_write> histogram: array<atomic<u32>, 256>;
#else
@group(0) @binding(2) var<storage, read_write> partials: array<vec2<f32>>;
#endif
#ifdef MASK
@group(0) @binding(3) var mask: texture_2d<f32>;
@group(0) @binding(4) var mask_sampler: sampler;
#endif
#ifdef OVERLAY
@group(0) @binding(5) var<storage, read> state: ExposureState;
#else
@group(0) @binding(5) var<storage, read_write> state: ExposureState;
#endif
@group(0) @binding(6) var<storage, read_write> bevy_view: View;
