// Makes the lobe of each texel: the weighted mean of the rays around it, its own and its neighbours', whose sixteen directions form a
// lobe (after Stachowiak 2015, "Stochastic Screen-Space Reflections"). Weights fall off linearly, within a radius of up to four texels:
// then the four directions along each axis weigh alike, and light moves smoothly from ray to ray. The radius is smaller where the lobe
// is. Lobes of rough surfaces are the mean of four frames.
#import bevy_lean_deferred::gbuffer::layout::light::unpack_halves
#import bevy_lean_deferred::effects::reflections::bindings::{
    filtered_output, lobes_output, unpack_begin, unpack_distance, unpack_weight, view, view_position,
}
#import bevy_lean_deferred::effects::reflections::lobes::{last_lobes, mean_lobe, with_lobe}
#import bevy_lean_deferred::effects::reflections::receiver::lobe_width
#import bevy_lean_deferred::effects::reflections::surface::ROUGH
#import bevy_lean_deferred::effects::reflections::texels::{
    FIRST_MADE, INVOCATIONS, MADE, RIM, CACHE_SIDE, depths, hits, inverse_step_at, keep, lights, likeness, normals, slope_at,
    texel_at,
}
#import bevy_lean_deferred::workgroup::is_any

/// Radius at which weights are 0, as a share of the lobe's, and its bounds in texels.
const OF_LOBE: f32 = 0.7;
const SMALLEST: f32 = 3.0;
const LARGEST: f32 = f32(RIM + 1);

/// Mean distance to the mirror images that the rays around a texel hit; 0 without any.
fn mean_image(texel: i32) -> f32 {
    var sum = 0.0;
    var count = 0.0;
    var other = texel - RIM * (1 + CACHE_SIDE);
    for (var y = -RIM; y <= RIM; y++) {
        for (var x = -RIM; x <= RIM; x++) {
            let image = unpack_distance(hits[other]);
            sum += image;
            count += select(0.0, 1.0, image > 0.0);
            other++;
        }
        other += CACHE_SIDE - 2 * RIM - 1;
    }
    return sum / max(count, 1.0);
}

/// Light times confidence, and confidence, of the rays around a texel, whose surface is `distance` from the camera.
fn lobe_at(texel: i32, distance: f32) -> vec4<f32> {
    let image = mean_image(texel);
    if image == 0.0 {
        return vec4(0.0);
    }
    let depth = depths[texel];
    let surface = unpack_halves(normals[texel]);
#ifdef PROJECTION_ORTHOGRAPHIC
    let width = lobe_width(image, 1.0);
#else
    let width = lobe_width(max(image - distance, 0.0), image);
#endif
    let radius = surface.w * surface.w * width / f32(view.divisor);
    let reach = clamp(OF_LOBE * radius, SMALLEST, LARGEST);
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
            let share = share_of_row * (reach - abs(f32(x)));
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
        var lobe = lobe_at(made, length(view_position(vec2<f32>(pixel) + 0.5, depth)));
        var lobes = vec4(0u);
        if unpack_halves(normals[made]).w > ROUGH {
            let last = last_lobes(texel, pixel, depth);
            lobes = with_lobe(last, lobe);
            lobe = mean_lobe(last, lobes);
        }
        textureStore(lobes_output, texel, lobes);
        textureStore(filtered_output, texel, lobe);
    }
}
