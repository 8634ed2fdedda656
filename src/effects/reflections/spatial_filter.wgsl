// Makes the lobe of each texel: the weighted mean of the rays around it, its own and its neighbours', whose sixteen directions form a
// lobe (after Stachowiak 2015, "Stochastic Screen-Space Reflections"). Weights fall off linearly, within a radius of up to four texels:
// then the four directions along each axis weigh alike, and light moves smoothly from ray to ray. The radius is smaller where the lobe
// is. On smooth surfaces, whose rays scatter only where the lobe is wider than two texels, the weights also follow the lobe's own shape.
// Lobes with rays that change from frame to frame are the mean of four frames.
#import bevy_lean_deferred::gbuffer::layout::light::unpack_halves
#import bevy_lean_deferred::effects::reflections::bindings::{
    CHANGES, filtered_output, lobes_output, to_viewer, unpack_begin, unpack_distance, unpack_weight, view, view_position,
}
#import bevy_lean_deferred::effects::reflections::lobes::{last_lobes, mean_lobe, with_lobe}
#import bevy_lean_deferred::effects::reflections::receiver::lobe_width
#import bevy_lean_deferred::effects::reflections::surface::{ROUGH, rotated}
#import bevy_lean_deferred::effects::reflections::texels::{
    FIRST_MADE, INVOCATIONS, MADE, RIM, CACHE_SIDE, depths, hits, inverse_step_at, keep, lights, likeness, normals, slope_at,
    texel_at,
}
#import bevy_lean_deferred::workgroup::is_any

/// Radius at which weights are 0, as a share of the lobe's, and its bounds in texels.
const OF_LOBE: f32 = 0.7;
const SMALLEST: f32 = 3.0;
/// Least radius of a smooth surface's lobe, in texels.
const LEAST_RADIUS: f32 = 0.25;
const LARGEST: f32 = f32(RIM + 1);

/// Rays around a texel.
struct Around {
    /// Mean distance to the mirror images that they hit; 0 without any.
    image: f32,
    /// `CHANGES` if one of them does.
    changes: u32,
}

fn around_of(texel: i32) -> Around {
    var sum = 0.0;
    var bits = 0u;
    var count = 0.0;
    var other = texel - RIM * (1 + CACHE_SIDE);
    for (var y = -RIM; y <= RIM; y++) {
        for (var x = -RIM; x <= RIM; x++) {
            let hit = hits[other];
            bits |= hit;
            let image = unpack_distance(hit);
            sum += image;
            count += select(0.0, 1.0, image > 0.0);
            other++;
        }
        other += CACHE_SIDE - 2 * RIM - 1;
    }
    return Around(sum / max(count, 1.0), bits & CHANGES);
}

/// 1 / the squared radius, in texels, of the lobe whose product with the linear weights is as wide at half maximum as a lobe of this
/// `radius`. From 3.1 texels on it is 0: the linear weights alone are as wide.
fn inverse_square(radius: f32) -> f32 {
    let wide = max(radius, LEAST_RADIUS);
    return max(sqrt(max(2.0 - 0.322 * wide, 0.0)) - 1.0, 0.0) / (0.414 * wide * wide);
}

/// Quadratic form of an offset in texels: the squared slope of the microfacet that reflects from there, relative to the roughness.
fn slopes_of(surface: vec4<f32>, position: vec3<f32>, radius: f32) -> mat2x2<f32> {
    let V = to_viewer(position);
    let normal = rotated(surface.xyz);
    let cosine = saturate(dot(V, normal));
    let away = normal - cosine * V;
    var axis = (away.xy * V.z - V.xy * away.z) * sign(view.pixels_per_metre);
    axis *= inverseSqrt(max(dot(axis, axis), 1e-12));
    // The lobe is narrower across the plane of incidence.
    let across = inverse_square(radius * cosine);
    let more = (inverse_square(radius) - across) * axis;
    return mat2x2(more * axis.x + vec2(across, 0.0), more * axis.y + vec2(0.0, across));
}

/// Light times confidence, and confidence, of the rays around a texel, whose surface is at `position`.
fn lobe_at(texel: i32, image: f32, position: vec3<f32>) -> vec4<f32> {
    if image == 0.0 {
        return vec4(0.0);
    }
    let depth = depths[texel];
    let surface = unpack_halves(normals[texel]);
#ifdef PROJECTION_ORTHOGRAPHIC
    let width = lobe_width(image, 1.0);
#else
    let width = lobe_width(max(image - length(position), 0.0), image);
#endif
    let radius = surface.w * surface.w * width / f32(view.divisor);
    var reach = LARGEST;
    var slopes = mat2x2(0.0, 0.0, 0.0, 0.0);
    if surface.w > ROUGH {
        reach = clamp(OF_LOBE * radius, SMALLEST, LARGEST);
    } else {
        slopes = slopes_of(surface, position, radius);
    }
    let last = i32(ceil(reach)) - 1;
    let slope = slope_at(texel);
    let inverse_step = inverse_step_at(depth);
    var sum = vec4(0.0);
    var weights = 0.0;
    // Incremented, because integer products are slow.
    var other = texel - last * (1 + CACHE_SIDE);
    for (var y = -last; y <= last; y++) {
        let expected_in_row = depth + slope.y * f32(y);
        let share_of_row = reach - abs(f32(y));
        for (var x = -last; x <= last; x++) {
            let expected = expected_in_row + slope.x * f32(x);
            let offset = vec2(f32(x), f32(y));
            // GGX.
            let spread = 1.0 + dot(offset, slopes * offset);
            let share = share_of_row * (reach - abs(f32(x))) / (spread * spread);
            let weight = share * likeness(surface.xyz, expected, other, inverse_step) * unpack_weight(hits[other]);
            sum += weight * unpack_halves(lights[other]);
            weights += weight;
            other++;
        }
        other += CACHE_SIDE - 2 * last - 1;
    }
    return sum / max(weights, 1e-6);
}

@compute @workgroup_size(INVOCATIONS, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let i = i32(invocation);
    let corner = vec2<i32>(workgroup.xy) * MADE;
    // Both reads are issued before the first is used.
    let first = texel_at(corner, i);
    let second = texel_at(corner, i + INVOCATIONS);
    var counts = keep(i, first);
    if i + INVOCATIONS < CACHE_SIDE * CACHE_SIDE {
        counts |= keep(i + INVOCATIONS, second);
    }
    if !is_any(counts, invocation) {
        return;
    }
    let place = vec2<i32>(vec2(invocation % u32(MADE), invocation / u32(MADE)));
    let made = place.x + CACHE_SIDE * place.y + FIRST_MADE;
    let depth = depths[made];
    // Other texels are not read.
    if depth > 0.0 {
        let texel = corner + place;
        let pixel = unpack_begin(texel, bitcast<u32>(depth));
        let around = around_of(made);
        var lobe = lobe_at(made, around.image, view_position(vec2<f32>(pixel) + 0.5, depth));
        var lobes = vec4(0u);
        if around.changes != 0u {
            let last = last_lobes(texel, pixel, depth);
            lobes = with_lobe(last, lobe);
            lobe = mean_lobe(last, lobes);
        }
        textureStore(lobes_output, texel, lobes);
        textureStore(filtered_output, texel, lobe);
    }
}
