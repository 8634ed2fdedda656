// The first pass: reads each pixel of the viewport once, or one in some, and leaves one partial sum for each workgroup,
// or what it adds to the histogram.
#import bevy_lean_deferred::auto_exposure::luminance::{log_luminance, luminance}
#import bevy_lean_deferred::auto_exposure::pattern::pattern_weight
#import bevy_lean_deferred::auto_exposure::reduction::{Place, workgroup_sum}
#import bevy_lean_deferred::auto_exposure::view::{
    BINS, BINS_PER_STOP, ExposureView, FULL_WEIGHT, LOG_OF_FIRST_BIN, TILE,
}

@group(0) @binding(0) var<uniform> view: ExposureView;
@group(0) @binding(1) var picture: texture_2d<f32>;
#ifdef HISTOGRAM
@group(0) @binding(2) var<storage, read_write> histogram: array<atomic<u32>, 256>;
var<workgroup> bins: array<atomic<u32>, 256>;
#else
@group(0) @binding(2) var<storage, read_write> partials: array<vec2<f32>>;
#endif
#ifdef MASK
@group(0) @binding(3) var mask: texture_2d<f32>;
@group(0) @binding(4) var mask_sampler: sampler;
#endif

/// How much a pixel of the viewport counts, 0 to 1.
fn weight_of(pixel: vec2<u32>) -> f32 {
    let size = vec2<f32>(view.viewport_size);
    let center = vec2<f32>(pixel) + 0.5;
#ifdef MASK
    return saturate(textureSampleLevel(mask, mask_sampler, center / size, 0.0).r);
#else
    return pattern_weight(center, size, view.spot_radius);
#endif
}

/// Which pixel the invocations read that would read `pixel` if all were read: 4×4 blocks, as caches hold them, with gaps
/// between them that differ from row to row.
fn spread(pixel: vec2<u32>) -> vec2<u32> {
#if STRIDE == 1
    return pixel;
#else
    let block = pixel / 4u;
    let gap = (block.y * (#{STRIDE}u - 1u)) % #{STRIDE}u;
    return 4u * (block * #{STRIDE}u + vec2(gap, 0u)) + pixel % 4u;
#endif
}

/// The weighted luminance of a pixel, and its weight.
fn measured(pixel: vec2<u32>) -> vec2<f32> {
    if any(pixel >= view.viewport_size) {
        return vec2(0.0);
    }
    let y = luminance(textureLoad(picture, view.viewport_origin + pixel, 0).rgb);
#ifdef WEIGHTED
    let weight = select(weight_of(pixel), 0.0, y < 0.0);
#else
    let weight = select(1.0, 0.0, y < 0.0);
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

fn count(place: Place, sample: vec2<f32>) {
    let weight = u32(sample.y * FULL_WEIGHT + 0.5);
#ifdef LOG_AVERAGE
    let log_y = sample.x / max(sample.y, 1e-6);
#else
    let log_y = log_luminance(sample.x / max(sample.y, 1e-6));
#endif
    let bin = bin_of(log_y);
#ifdef SUBGROUPS
    // Neighbours mostly share a bin: one addition for all that have the first one's.
    let first = subgroupBroadcastFirst(bin);
    let together = subgroupAdd(select(0u, weight, bin == first));
    if place.in_subgroup == 0u {
        atomicAdd(&bins[first], together);
    }
    if bin != first && weight > 0u {
        atomicAdd(&bins[bin], weight);
    }
#else
    if weight > 0u {
        atomicAdd(&bins[bin], weight);
    }
#endif
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
    // 16×16 pixels at a time, in 2×2 quads, so that neighbours in memory are read together.
    let quad = vec2(invocation & 1u, (invocation >> 1u) & 1u);
    let in_square = quad + 2u * vec2((invocation >> 2u) & 7u, invocation >> 5u);
    var sum = vec2(0.0);
    for (var y = 0u; y < 8u; y++) {
        for (var x = 0u; x < 4u; x++) {
            let sample = measured(spread(tile.xy * TILE + 16u * vec2(x, y) + in_square));
#ifdef HISTOGRAM
            count(place, sample);
#else
            sum += sample;
#endif
        }
    }
#ifdef HISTOGRAM
    workgroupBarrier();
    let counted = atomicLoad(&bins[invocation]);
    if counted > 0u {
        atomicAdd(&histogram[invocation], counted);
    }
#else
    let total = workgroup_sum(place, sum);
    if invocation == 0u {
        partials[tile.y * tiles.x + tile.x] = total;
    }
#endif
}
