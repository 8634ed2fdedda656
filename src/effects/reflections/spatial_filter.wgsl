// Makes the lobe of each texel: the mean of 5×5 rays, its own and its neighbours', whose sixteen directions form a lobe (after
// Stachowiak 2015, "Stochastic Screen-Space Reflections"). The outer rays weigh half: the four directions along each axis then
// weigh alike, and hits have no hard edges.
#import bevy_lean_deferred::gbuffer::layout::light::unpack_halves
#import bevy_lean_deferred::effects::reflections::bindings::{filtered_output, unpack_weight}
#import bevy_lean_deferred::effects::reflections::texels::{
    FIRST_MADE, INVOCATIONS, MADE, RIM, CACHE_SIDE, depths, hits, inverse_step_at, keep, lights, likeness, normals, slope_at,
    texel_at,
}
#import bevy_lean_deferred::workgroup::is_any

/// Light times confidence, and confidence, of the rays around a texel.
fn lobe_at(texel: i32) -> vec4<f32> {
    let depth = depths[texel];
    let normal = unpack_halves(normals[texel]).xyz;
    let slope = slope_at(texel);
    let inverse_step = inverse_step_at(depth);
    var sum = vec4(0.0);
    var weights = 0.0;
    // Incremented, because integer products are slow.
    var other = texel - RIM * (1 + CACHE_SIDE);
    for (var y = -RIM; y <= RIM; y++) {
        let expected_in_row = depth + slope.y * f32(y);
        let share_of_row = f32(2 - ((y * y) >> 2u));
        for (var x = -RIM; x <= RIM; x++) {
            let expected = expected_in_row + slope.x * f32(x);
            let share = share_of_row * f32(2 - ((x * x) >> 2u));
            let weight = share * likeness(normal, expected, other, inverse_step) * unpack_weight(hits[other]);
            sum += weight * unpack_halves(lights[other]);
            weights += weight;
            other++;
        }
        other += CACHE_SIDE - 2 * RIM - 1;
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
    // Other texels are not read.
    if depths[made] > 0.0 {
        textureStore(filtered_output, corner + place, lobe_at(made));
    }
}
