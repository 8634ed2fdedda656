// Makes the lobe of each texel: the weighted mean of the rays around it, its own and its neighbours', whose sixteen directions form a
// lobe (after Stachowiak 2015, "Stochastic Screen-Space Reflections"). Weights fall off linearly, within a radius of up to four texels:
// then the four directions along each axis weigh alike, and light moves smoothly from ray to ray. The radius is smaller where the lobe
// is. On smooth surfaces, whose rays scatter only where the lobe is wider than two texels, the weights also follow the lobe's own shape.
// Lobes with rays that change from frame to frame are the mean of four frames. While mirror images move, the last three weigh less the
// more they differ from this frame's.
#import bevy_lean_deferred::gbuffer::layout::{light::unpack_halves, unpack_roughness}
#import bevy_lean_deferred::effects::reflections::bindings::{
    CHANGES, MOVES, filtered_output, lobes_output, surfaces_texture, to_viewer, unpack_begin, unpack_distance, view,
    view_position,
}
#import bevy_lean_deferred::effects::reflections::lobes::{
    ALL_ALIKE, EXACT, KNOWN, MOVED, OF_MOVERS, exposed, has_moved, last_lobe_place, lobes_at, mean_lobe, mean_lobes,
    with_lobe,
}
#import bevy_lean_deferred::effects::reflections::surface::{ROUGH, lobe_width, rotated}
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
/// Texels in a row of the largest kernel.
const ROW: i32 = 2 * RIM + 1;
/// Radii of a smooth surface's lobe within which weights are above 1/400.
const OF_NARROW: f32 = 4.36;

/// Sum `i` over the hits of seven texels in a row, packed like a hit: of the distances to mirror images, and in the lower bits, how many
/// there are, and `CHANGES` and `MOVES` if a ray does.
fn row_sum(i: u32) -> u32 {
    var texel = i / u32(MADE) * u32(CACHE_SIDE) + i % u32(MADE);
    var sum = 0.0;
    var bits = 0u;
    var count = 0u;
    for (var x = 0; x <= 2 * RIM; x++) {
        let hit = hits[texel];
        bits |= hit;
        let image = unpack_distance(hit);
        sum += image;
        count += select(0u, 4u, image > 0.0);
        texel++;
    }
    return (bitcast<u32>(sum) & 0xffffff00u) | count | (bits & (CHANGES | MOVES));
}

/// Rows of seven texels in a workgroup.
const ROWS: u32 = u32(MADE * CACHE_SIDE);

/// Rays around a texel.
struct Around {
    /// Mean distance to the mirror images that they hit; 0 without any.
    image: f32,
    /// `CHANGES` and `MOVES` if one of them does, among other bits.
    bits: u32,
}

/// Rays around texel `i` of those that the workgroup makes. `hits` has the sums of rows.
fn around_of(i: u32) -> Around {
    var sum = 0.0;
    var bits = 0u;
    var count = 0u;
    for (var y = 0u; y <= 2u * u32(RIM); y++) {
        let row = hits[i + y * u32(MADE)];
        bits |= row;
        sum += unpack_distance(row);
        count += (row >> 2u) & 7u;
    }
    return Around(sum / f32(max(count, 1u)), bits);
}

/// Index, relative to a texel's, of the first of the 4×4 rays around it, which take all directions.
const FIRST_OF_LOBE: i32 = -2 * (1 + CACHE_SIDE);

/// Mean distance to the mirror images that the rays around a texel hit, weighted by their light; 0 without any. Lobes that move show
/// errors where they are bright.
fn bright_image(texel: i32) -> f32 {
    var sum = 0.0;
    var weights = 0.0;
    for (var i = 0; i < 16; i++) {
        let ray = texel + FIRST_OF_LOBE + (i & 3) + CACHE_SIDE * (i >> 2u);
        let light = unpack_halves(lights[ray]);
        let weight = light.r + light.g + light.b;
        sum += weight * unpack_distance(hits[ray]);
        weights += weight;
    }
    return sum / max(weights, 1e-6);
}

/// Mean difference, summed over its components, of the rays around a texel from their mean, `light`. Weights fall off linearly, within
/// three texels: equal ones would show squares around bright rays.
fn difference_around(texel: i32, light: vec4<f32>) -> f32 {
    var sum = 0.0;
    for (var y = -2; y <= 2; y++) {
        var row = 0.0;
        for (var x = -2; x <= 2; x++) {
            let off = abs(unpack_halves(lights[texel + x + CACHE_SIDE * y]) - light);
            row += f32(3 - abs(x)) * (off.r + off.g + off.b + off.a);
        }
        sum += f32(3 - abs(y)) * row;
    }
    return sum / 81.0;
}

/// 1 / the squared radius, in texels, of the lobe whose product with the linear weights is as wide at half maximum as a lobe of this
/// `radius`. From 3.1 texels on it is 0: the linear weights alone are as wide.
fn inverse_square(radius: f32) -> f32 {
    let wide = max(radius, LEAST_RADIUS);
    return max(sqrt(max(2.0 - 0.322 * wide, 0.0)) - 1.0, 0.0) / (0.414 * wide * wide);
}

/// Quadratic form of an offset in texels: the squared slope of the microfacet that reflects from there, relative to the roughness.
/// Factors of x², 2·x·y and y².
fn slopes_of(normal: vec3<f32>, position: vec3<f32>, radius: f32) -> vec3<f32> {
    let V = to_viewer(position);
    let cosine = saturate(dot(V, normal));
    let away = normal - cosine * V;
    var axis = (away.xy * V.z - V.xy * away.z) * sign(view.pixels_per_metre);
    axis *= inverseSqrt(max(dot(axis, axis), 1e-12));
    // The lobe is narrower across the plane of incidence.
    let across = inverse_square(radius * cosine);
    let more = (inverse_square(radius) - across) * axis;
    return vec3(more.x * axis.x + across, more.x * axis.y, more.y * axis.y + across);
}

/// Lobe of a texel in this frame.
struct Lobe {
    /// Light times confidence, and confidence.
    light: vec4<f32>,
    /// False if all of its light is unknown.
    is_known: bool,
}

/// Mean of the rays around a texel, whose surface is at `position`.
fn lobe_at(texel: i32, roughness: f32, image: f32, position: vec3<f32>) -> Lobe {
    if image == 0.0 {
        return Lobe(vec4(0.0), true);
    }
    let depth = depths[texel];
    let normal = unpack_halves(normals[texel]).xyz;
#ifdef PROJECTION_ORTHOGRAPHIC
    let width = lobe_width(image, 1.0);
#else
    let width = lobe_width(max(image - length(position), 0.0), image);
#endif
    let radius = roughness * roughness * width / f32(view.divisor);
    var reach = LARGEST;
    var last = RIM;
    var slopes = vec3(0.0);
    if roughness > ROUGH {
        reach = clamp(OF_LOBE * radius, SMALLEST, LARGEST);
        last = i32(ceil(reach)) - 1;
    } else {
        last = i32(clamp(OF_NARROW * inverseSqrt(inverse_square(radius)), 1.0, f32(RIM)));
        slopes = slopes_of(rotated(normal), position, radius);
    }
    // Wide lobes are made by the linear weights alone.
    let is_narrow = any(slopes != vec3(0.0));
    let slope = slope_at(texel);
    let inverse_step = inverse_step_at(depth);
    var sum = vec4(0.0);
    var weights = 0.0;
    // Incremented, because integer products are slow.
    var middle = texel - last * CACHE_SIDE;
    for (var y = -last; y <= last; y++) {
        let down = f32(y);
        let share_of_row = reach - abs(down);
        // Of the whole row: the loops are unrolled then.
        var row: array<f32, ROW>;
        for (var x = -RIM; x <= RIM; x++) {
            let along = f32(x);
            let share = share_of_row * max(reach - abs(along), 0.0);
            let expected = depth + slope.y * down + slope.x * along;
            row[x + RIM] = share * likeness(normal, expected, middle + x, inverse_step);
        }
        if is_narrow {
            for (var x = -RIM; x <= RIM; x++) {
                let along = f32(x);
                // GGX.
                let spread = slopes.z * down * down + 1.0 + (slopes.y * 2.0 * down + slopes.x * along) * along;
                row[x + RIM] *= 1.0 / (spread * spread);
            }
        }
        for (var x = -RIM; x <= RIM; x++) {
            let weight = row[x + RIM];
            sum += weight * unpack_halves(lights[middle + x]);
            weights += weight * unpack2x16float(normals[middle + x].y).y;
        }
        middle += CACHE_SIDE;
    }
    return Lobe(sum / max(weights, 1e-6), weights > 1e-4);
}

/// Lobes of the last frames.
struct LastLobes {
    lobes: vec4<u32>,
    /// Difference from this frame's lobe at which they weigh 1/2: see `OF_IMAGES`.
    tolerance: f32,
}

/// The lobes of the last frames of the surface of texel `made`, whose ray begins at `pixel`.
fn last_lobes(made: i32, texel: vec2<i32>, pixel: vec2<i32>, roughness: f32, image: f32, moves: bool) -> LastLobes {
    let depth = depths[made];
    let slope = slope_at(made);
    let normal = unpack_halves(normals[made]).xyz;
    let place = last_lobe_place(pixel, depth, slope, rotated(normal), roughness, image, moves);
    var last = LastLobes(vec4(0u), place.tolerance);
    if !place.is_known {
        return last;
    }
    let along_texels = floor(place.at + 0.5);
    let off = place.at - along_texels;
    let nearest = vec2<f32>(texel) + along_texels;
    if all(abs(off) < vec2(EXACT)) {
        last.lobes = exposed(lobes_at(nearest));
        return last;
    }
    // Interpolated, so that no seams appear where the nearest texel changes. This frame's neighbours stand for those of the last one.
    let side = sign(off);
    let along = i32(side.x);
    let down = CACHE_SIDE * i32(side.y);
    let inverse_step = inverse_step_at(depth);
    let alike = vec4(
        1.0,
        likeness(normal, depth + slope.x * side.x, made + along, inverse_step),
        likeness(normal, depth + slope.y * side.y, made + down, inverse_step),
        likeness(normal, depth + dot(slope, side), made + along + down, inverse_step),
    );
    let kept = array<vec4<u32>, 4>(
        lobes_at(nearest),
        lobes_at(nearest + vec2(side.x, 0.0)),
        lobes_at(nearest + vec2(0.0, side.y)),
        lobes_at(nearest + side),
    );
    let far = abs(off);
    let near = 1.0 - far;
    last.lobes = exposed(mean_lobes(kept, vec4(near.x, far.x, near.x, far.x) * vec4(near.yy, far.yy) * alike));
    return last;
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
    // In place of the hits, which nothing else reads.
    let sums = vec2(row_sum(invocation), row_sum(min(invocation + u32(INVOCATIONS), ROWS - 1u)));
    let place = vec2<i32>(vec2(invocation % u32(MADE), invocation / u32(MADE)));
    let made = place.x + CACHE_SIDE * place.y + FIRST_MADE;
    // Only used while the camera moves.
    var bright = 0.0;
    if view.carries_surfaces != 0u {
        bright = bright_image(made);
    }
    workgroupBarrier();
    hits[invocation] = sums.x;
    if invocation + u32(INVOCATIONS) < ROWS {
        hits[invocation + u32(INVOCATIONS)] = sums.y;
    }
    workgroupBarrier();
    let depth = depths[made];
    // Other texels are not read.
    if depth > 0.0 {
        let texel = corner + place;
        let pixel = unpack_begin(texel, bitcast<u32>(depth));
        let around = around_of(invocation);
        let roughness = unpack_roughness(textureLoad(surfaces_texture, texel, 0).r);
        // Requested before the rays are averaged, and awaited after.
        let changes = (around.bits & CHANGES) != 0u;
        let moves = (around.bits & MOVES) != 0u;
        var last = LastLobes(vec4(0u), ALL_ALIKE);
        if changes && view.has_lobes != 0u && view.exposure_ratio != 0.0 {
            last = last_lobes(made, texel, pixel, roughness, select(around.image, bright, bright > 0.0), moves);
        }
        let now = lobe_at(made, roughness, around.image, view_position(vec2<f32>(pixel) + 0.5, depth));
        var lobe = now.light;
        var lobes = vec4(0u);
        if changes {
            let bits = select(0u, KNOWN, now.is_known) | select(0u, MOVED, moves);
            lobes = with_lobe(last.lobes, lobe, bits);
            let tolerance = select(last.tolerance, OF_MOVERS, has_moved(last.lobes, lobes));
            var most = 1e30;
            if now.is_known && tolerance < ALL_ALIKE {
                most = tolerance * difference_around(made, lobe);
            }
            lobe = mean_lobe(last.lobes, lobes, most);
        }
        textureStore(lobes_output, texel, lobes);
        textureStore(filtered_output, texel, lobe);
    }
}
