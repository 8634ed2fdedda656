// What a rough surface mirrors: the mean of 5×5 rays, whose sixteen directions make a lobe.
#define_import_path bevy_lean_deferred::screen_space::reflections::rough_light

#import bevy_lean_deferred::screen_space::reflections::bindings::{DIVISOR, ROUGH_STEP, edge_step, unpack_weight}
#import bevy_lean_deferred::screen_space::reflections::texels::{
    FIRST_MADE, IS_ROUGH, REACH, Receiver, SIDE, TEXELS, depths, hits, light_around, lights, likeness, likeness_of, normals,
    pack_halves, slope_at, unpack_halves,
}

/// Means of rays a side, as far apart as the rays of rough surfaces: those around all pixels.
const MEANS: i32 = TEXELS / ROUGH_STEP + 1;
/// Light times confidence, and confidence, of 5×5 rays.
var<workgroup> means: array<vec2<u32>, MEANS * MEANS>;

/// Light times confidence, and confidence, of the rays around a texel.
fn mean_at(texel: i32) -> vec4<f32> {
    let depth = depths[texel];
    var sum = vec4(0.0);
    if depth == 0.0 {
        return sum;
    }
    let normal = unpack_halves(normals[texel]).xyz;
    let slope = slope_at(texel);
    let inverse_step = 1.0 / edge_step(depth, f32(DIVISOR));
    let apart = select(1, ROUGH_STEP, (hits[texel] & IS_ROUGH) != 0u);
    let slope_apart = slope * f32(apart);
    var weights = 0.0;
    // Goes along, since products of integers are slow.
    var other = texel - REACH * apart * (1 + SIDE);
    for (var y = -REACH; y <= REACH; y++) {
        let expected_in_row = depth + slope_apart.y * f32(y);
        let share_of_row = f32(2 - ((y * y) >> 2u));
        for (var x = -REACH; x <= REACH; x++) {
            let expected = expected_in_row + slope_apart.x * f32(x);
            let share = share_of_row * f32(2 - ((x * x) >> 2u));
            let weight = share * likeness(normal, expected, other, inverse_step) * unpack_weight(hits[other]);
            sum += weight * unpack_halves(lights[other]);
            weights += weight;
            other += apart;
        }
        other += apart * (SIDE - 2 * REACH - 1);
    }
    return sum / max(weights, 1e-6);
}

/// Makes one of `means`, by its place there.
fn make_mean(mean: i32) {
    let place = vec2<i32>(vec2(u32(mean) % u32(MEANS), u32(mean) / u32(MEANS)));
    means[mean] = pack_halves(mean_at(ROUGH_STEP * (place.x + SIDE * place.y) + FIRST_MADE));
}

/// Light times confidence, and confidence: between the means around the pixel. In each of them those that make a lobe weigh
/// alike, and so they do between them.
fn rough_light(receiver: Receiver, place: vec2<i32>, first: i32, along: vec2<f32>) -> vec4<f32> {
    let corner = vec2<i32>(vec2<u32>(place) / u32(ROUGH_STEP));
    let mean = corner.x + MEANS * corner.y;
    let texel = ROUGH_STEP * (corner.x + SIDE * corner.y) + FIRST_MADE;
    let along_means = (vec2<f32>(vec2<u32>(place) % u32(ROUGH_STEP)) + along) / f32(ROUGH_STEP);
    var sum = vec4(0.0);
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let corner = vec2(i & 1, i >> 1u);
        let near = select(1.0 - along_means, along_means, corner == vec2(1));
        let offset = f32(ROUGH_STEP) * (vec2<f32>(corner) - along_means);
        let alike = likeness_of(receiver, texel + ROUGH_STEP * (corner.x + SIDE * corner.y), offset);
        let weight = near.x * near.y * alike;
        sum += weight * unpack_halves(means[mean + corner.x + MEANS * corner.y]);
        weights += weight;
    }
    // What is narrower than means are apart.
    if weights < 0.02 {
        return light_around(receiver, first, along);
    }
    return sum / weights;
}
