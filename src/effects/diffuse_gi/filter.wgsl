// Filters gathered light: the mean of 4×4 texels, whose slices cover all directions of the pattern, without texels of other
// surfaces. Where few of the directions have most of the light, as beside a small lamp, the mean of sixteen such means.
#import bevy_lean_deferred::gbuffer::layout::light::{LARGEST_HALF, pack_halves, unpack_halves}
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::effects::diffuse_gi::bindings::{
    edge_step, gathered_texture, levels, output_texture, view,
}
#import bevy_lean_deferred::effects::diffuse_gi::entry::unpack_depth

/// Side of the texels of a workgroup.
const SIDE: u32 = 16u;
/// Invocations of a workgroup.
const STRIDE: u32 = 256u;
/// Side of the means that it computes: its own, four before and three after.
const MEANS_SIDE: u32 = 23u;
/// Side of the texels that these are means of: one before them and two after.
const CACHE_SIDE: u32 = 26u;

/// Gathered light, and then its means over 4×4 texels, as halves.
var<workgroup> light: array<vec2<u32>, 676>;
var<workgroup> depths: array<f32, 676>;
/// Means of the squares of `total`.
var<workgroup> squares: array<f32, 529>;

/// Squared coefficients of variation of the texels' light from which on the wide mean counts, and counts alone. Of sixteen texels of
/// which one to eight see a lamp, it is 15 to 1.
const SPARSE: f32 = 0.5;
const SPARSEST: f32 = 1.5;
/// Weight of other means on the surface from which on the wide mean counts in full.
const ENOUGH: f32 = 4.0;

fn total(color: vec3<f32>) -> f32 {
    return color.r + color.g + color.b;
}

/// The surface around a texel as a plane: depth is affine on screen.
struct Plane {
    depth: f32,
    slope: vec2<f32>,
    inverse_step: f32,
}

fn plane_at(center: u32) -> Plane {
    let depth = depths[center];
    let slope = vec2(
        flatter_slope(depths[center - 1u], depth, depths[center + 1u]),
        flatter_slope(depths[center - CACHE_SIDE], depth, depths[center + CACHE_SIDE]),
    );
    return Plane(depth, slope, 1.0 / edge_step(depth, f32(view.divisor)));
}

/// Weight, 0 to 1, of a texel of this depth at `offset` from the plane's centre.
fn weight_on(plane: Plane, depth: f32, offset: vec2<f32>) -> f32 {
    let expected = plane.depth + dot(plane.slope, offset);
    let alike = saturate(2.0 - abs(depth - expected) * plane.inverse_step);
    return min(alike, 1.0) * f32(depth > 0.0);
}

struct Mean {
    /// As halves.
    light: vec2<u32>,
    /// Of `total`.
    square: f32,
}

/// Mean of the 4×4 texels around the texel of a mean, from `light`.
fn mean_at(mean: u32) -> Mean {
    let center = (mean % MEANS_SIDE + 1u) + CACHE_SIDE * (mean / MEANS_SIDE + 1u);
    var sum = vec4(0.0);
    var sum_of_squares = 0.0;
    var weights = 1e-6;
    if depths[center] > 0.0 {
        let plane = plane_at(center);
        for (var y = 0u; y < 4u; y++) {
            for (var x = 0u; x < 4u; x++) {
                let other = center + x + CACHE_SIDE * y - 1u - CACHE_SIDE;
                let weight = weight_on(plane, depths[other], vec2(f32(x), f32(y)) - 1.0);
                let gathered = unpack_halves(light[other]);
                let brightness = total(gathered.rgb);
                sum += gathered * weight;
                sum_of_squares += brightness * brightness * weight;
                weights += weight;
            }
        }
    }
    return Mean(pack_halves(sum / weights), sum_of_squares / weights);
}

fn keep(index: u32, mean: Mean) {
    light[index] = mean.light;
    squares[index] = mean.square;
}

@compute @workgroup_size(256, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    let corner = vec2<i32>(workgroup.xy * SIDE) - 5;
    let last = vec2<i32>(view.texture_size) - 1;
    for (var read = i; read < CACHE_SIDE * CACHE_SIDE; read += STRIDE) {
        let texel = corner + vec2<i32>(vec2(read % CACHE_SIDE, read / CACHE_SIDE));
        let inside = clamp(texel, vec2(0), last);
        light[read] = pack_halves(min(textureLoad(gathered_texture, inside, 0), vec4(LARGEST_HALF)));
        let depth = unpack_depth(textureLoad(levels, inside, 0).r);
        // Texels beyond the border have no weight.
        depths[read] = select(0.0, depth, all(texel == inside));
    }
    workgroupBarrier();

    // The means take the place of the light, once all are computed.
    let first = mean_at(i);
    let second = mean_at(i + STRIDE);
    var third: Mean;
    let has_third = i + 2u * STRIDE < MEANS_SIDE * MEANS_SIDE;
    if has_third {
        third = mean_at(i + 2u * STRIDE);
    }
    workgroupBarrier();
    keep(i, first);
    keep(i + STRIDE, second);
    if has_third {
        keep(i + 2u * STRIDE, third);
    }
    workgroupBarrier();

    let place = vec2(i % SIDE, i / SIDE);
    let texel = workgroup.xy * SIDE + place;
    if any(texel >= view.texture_size) {
        return;
    }
    let center = (place.x + 5u) + CACHE_SIDE * (place.y + 5u);
    var found = vec4(0.0);
    if depths[center] > 0.0 {
        let own = (place.x + 4u) + MEANS_SIDE * (place.y + 4u);
        let narrow = unpack_halves(light[own]);
        let plane = plane_at(center);
        var sum = vec4(0.0);
        var sum_of_squares = 0.0;
        var weights = 1e-6;
        // Means at -4, -1, 0 and 3 along both axes: as many at even places as at odd ones, so that neighbours are alike.
        for (var y = 0u; y < 4u; y++) {
            for (var x = 0u; x < 4u; x++) {
                let step = 2u * vec2(x, y) + (vec2(x, y) & vec2(1u));
                let other = place + step;
                let depth = depths[(other.x + 1u) + CACHE_SIDE * (other.y + 1u)];
                let weight = weight_on(plane, depth, vec2<f32>(step) - 4.0);
                let mean = other.x + MEANS_SIDE * other.y;
                sum += unpack_halves(light[mean]) * weight;
                sum_of_squares += squares[mean] * weight;
                weights += weight;
            }
        }
        let wide = sum / weights;
        let brightness = total(wide.rgb);
        let variation = sum_of_squares / weights / max(brightness * brightness, 1e-12) - 1.0;
        let share = saturate((variation - SPARSE) / (SPARSEST - SPARSE)) * saturate(weights / ENOUGH);
        found = mix(narrow, wide, share);
    }
    // Clamp to the whole hemisphere.
    textureStore(output_texture, texel, found / max(found.a, 1.0));
}
