// First pass: reads all pixels of the viewport, and writes one partial sum per workgroup or adds to the histogram.
#import bevy_lean_deferred::effects::auto_exposure::bindings::{
    BINS, BINS_PER_STOP, FULL_WEIGHT, LOG_OF_FIRST_BIN, TILE_WIDTH, picture, view,
}
#import bevy_lean_deferred::effects::auto_exposure::luminance::{
    LARGEST, SMALLEST, WEIGHTS, is_nan, log_luminance, luminance,
}
#import bevy_lean_deferred::effects::auto_exposure::pattern::pattern_weight
#import bevy_lean_deferred::effects::auto_exposure::reduction::{Place, workgroup_sum}
#import bevy_lean_deferred::tiles::{TILE_SIDE, place_in_tile}

#ifdef HISTOGRAM
#import bevy_lean_deferred::effects::auto_exposure::bindings::histogram
var<workgroup> bins: array<atomic<u32>, 256>;
#else
#import bevy_lean_deferred::effects::auto_exposure::bindings::partials
#endif
#ifdef MASK
#import bevy_lean_deferred::effects::auto_exposure::bindings::{mask, mask_sampler}
#endif

/// Metering weight of a viewport pixel, 0 to 1.
fn weight_of(pixel: vec2<u32>) -> f32 {
    let size = vec2<f32>(view.viewport_size);
    let center = vec2<f32>(pixel) + 0.5;
#ifdef MASK
    let weight = textureSampleLevel(mask, mask_sampler, center / size, 0.0).r;
    // NaN in a mask counts as 0.
    return select(0.0, min(weight, 1.0), weight > 0.0);
#else
    return pattern_weight(center, size, view.spot_radius);
#endif
}

/// Colour of a viewport pixel; beyond the viewport, of its last one.
fn color_at(pixel: vec2<u32>) -> vec3<f32> {
    let inside = min(pixel, view.viewport_size - 1u);
    return textureLoad(picture, view.viewport_origin + inside, 0).rgb;
}

/// Weighted luminance (with LOG_AVERAGE its logarithm) of a pixel, and its weight.
fn measured(color: vec3<f32>, pixel: vec2<u32>) -> vec2<f32> {
    let y = luminance(color);
    let counts = all(pixel < view.viewport_size) && y >= 0.0;
#ifdef WEIGHTED
    let weight = select(0.0, weight_of(pixel), counts);
#else
    let weight = select(0.0, 1.0, counts);
#endif
#ifdef LOG_AVERAGE
    return vec2(log_luminance(y), 1.0) * weight;
#else
    return vec2(y, 1.0) * weight;
#endif
}

#ifdef HISTOGRAM
fn bin_of(log_y: f32) -> u32 {
    return u32(clamp((log_y - LOG_OF_FIRST_BIN) * BINS_PER_STOP, 0.0, f32(BINS - 1u)));
}

/// Adds a sample to the workgroup's histogram.
fn count(place: Place, sample: vec2<f32>) {
    let weight = u32(sample.y * FULL_WEIGHT + 0.5);
#ifdef LOG_AVERAGE
    let log_y = sample.x / max(sample.y, 1e-6);
#else
    let log_y = log_luminance(sample.x / max(sample.y, 1e-6));
#endif
    let bin = bin_of(log_y);
#ifdef SUBGROUPS
    // In flat regions, all invocations would contend for one bin.
    let first = subgroupBroadcastFirst(bin);
    if subgroupAll(bin == first) {
        let together = subgroupAdd(weight);
        if place.in_subgroup == 0u {
            atomicAdd(&bins[first], together);
        }
        return;
    }
#endif
    if weight > 0u {
        atomicAdd(&bins[bin], weight);
    }
}
#endif

/// Position of invocation `i` in a square of 16×16 pixels.
fn place_in_square(i: u32) -> vec2<u32> {
    return place_in_tile(i & 63u) + TILE_SIDE * vec2((i >> 6u) & 1u, i >> 7u);
}

#ifdef LOG_OF_PRODUCTS
/// Luminance of a pixel as a factor of a product, and its weight: 1 if it counts.
fn factor(color: vec3<f32>, pixel: vec2<u32>) -> vec2<f32> {
    let y = dot(color, WEIGHTS);
    let counts = !is_nan(y) && all(pixel < view.viewport_size);
    return select(vec2(1.0, 0.0), vec2(clamp(y, SMALLEST, LARGEST), 1.0), counts);
}

/// Contribution of four pixels in a row, 16 apart, to the sum and to the weight. The logarithm of a product is the sum of the
/// logarithms and takes a quarter of the time. Products of four lie between 2⁻⁵⁶ and 2⁶⁴.
fn sum_of_four(
    place: Place, pixel: vec2<u32>, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>,
) -> vec2<f32> {
    let w = factor(a, pixel);
    let x = factor(b, pixel + vec2(16u, 0u));
    let y = factor(c, pixel + vec2(32u, 0u));
    let z = factor(d, pixel + vec2(48u, 0u));
    return vec2(log2((w.x * x.x) * (y.x * z.x)), (w.y + x.y) + (y.y + z.y));
}
#else
/// Measures a pixel, and adds it to the histogram if there is one.
fn counted(place: Place, color: vec3<f32>, pixel: vec2<u32>) -> vec2<f32> {
    let sample = measured(color, pixel);
#ifdef HISTOGRAM
    count(place, sample);
#endif
    return sample;
}

/// Contribution of four pixels in a row, 16 apart, to the sum and to the weight.
fn sum_of_four(
    place: Place, pixel: vec2<u32>, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>,
) -> vec2<f32> {
    let w = counted(place, a, pixel);
    let x = counted(place, b, pixel + vec2(16u, 0u));
    let y = counted(place, c, pixel + vec2(32u, 0u));
    let z = counted(place, d, pixel + vec2(48u, 0u));
    return (w + x) + (y + z);
}
#endif

@compute @workgroup_size(256, 1, 1)
fn meter(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(num_workgroups) tiles: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
#ifdef SUBGROUPS
    @builtin(subgroup_invocation_id) in_subgroup: u32,
    @builtin(subgroup_id) subgroup: u32,
    @builtin(num_subgroups) subgroups: u32,
#endif
) {
#ifdef SUBGROUPS
    let place = Place(invocation, in_subgroup, subgroup, subgroups);
#else
    let place = Place(invocation);
#endif
#ifdef HISTOGRAM
    atomicStore(&bins[invocation], 0u);
    workgroupBarrier();
#endif
    // 16×16 pixels at a time in Z-order, so that a subgroup's pixels are close in memory. Eight such squares are read before any
    // is used, to hide memory latency.
    let corner = tile.xy * vec2(TILE_WIDTH, view.tile_height) + place_in_square(invocation);
    var sum = vec2(0.0);
    for (var y = 0u; y < view.tile_height; y += 32u) {
        let a = corner + vec2(0u, y);
        let b = corner + vec2(0u, y + 16u);
        let a0 = color_at(a);
        let a1 = color_at(a + vec2(16u, 0u));
        let a2 = color_at(a + vec2(32u, 0u));
        let a3 = color_at(a + vec2(48u, 0u));
        let b0 = color_at(b);
        let b1 = color_at(b + vec2(16u, 0u));
        let b2 = color_at(b + vec2(32u, 0u));
        let b3 = color_at(b + vec2(48u, 0u));
        sum += sum_of_four(place, a, a0, a1, a2, a3);
        sum += sum_of_four(place, b, b0, b1, b2, b3);
    }
#ifdef HISTOGRAM
    workgroupBarrier();
    let own = atomicLoad(&bins[invocation]);
    if own > 0u {
        atomicAdd(&histogram[invocation], own);
    }
#else
    let total = workgroup_sum(place, sum);
    if invocation == 0u {
        partials[tile.y * tiles.x + tile.x] = total;
    }
#endif
}
