// What each pixel mirrors, of what the rays around it have found. A rough mirror has the mean of 5×5, whose sixteen
// directions make a lobe. A smooth one has the light of one place: where its own ray ends, as far away as those beside it went.
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::screen_space::reflections::bindings::{
    DIVISOR, ROUGH_STEP, depth_in_view, depth_texture, edge_step, homogeneous_pixel, hits_texture, output_texture, rays_texture, sends_ray,
    step_of_rays, to_viewer, unpack_distance, unpack_weight, view, view_position,
}
#import bevy_lean_deferred::screen_space::reflections::surface::{
    last_light, mirror_of, normal_word_at, rotated, smoothness,
}

/// Texels a side of a workgroup, and invocations.
const TEXELS: i32 = 16;
const INVOCATIONS: i32 = TEXELS * TEXELS;
/// Pixels a side.
const PIXELS: i32 = TEXELS * DIVISOR;
/// Means of rays a side, as far apart as the rays of rough surfaces: those around all pixels.
const MEANS: i32 = TEXELS / ROUGH_STEP + 1;
/// Rays that a mean is of, each way from its own. The outer ones weigh half as much: each of the four directions that rays have along an
/// axis then weighs alike, and what a ray has met has no hard edges.
const REACH: i32 = 2;
/// Texels a side that are read: those of all means.
const SIDE: i32 = TEXELS + 1 + 2 * REACH * ROUGH_STEP;
/// The first of the texels whose pixels are made.
const FIRST_MADE: i32 = REACH * ROUGH_STEP * (1 + SIDE);

/// Radius of a lobe where it meets a surface, in pixels, up to which it is taken for a single place, and from which on it
/// is the mean of rays.
const SMOOTH_UP_TO: f32 = 2.0;
const ROUGH_FROM: f32 = 8.0;

/// Half floats of light times confidence, and confidence: many workgroups are to find room.
var<workgroup> lights: array<vec2<u32>, SIDE * SIDE>;
/// Normals in half floats, and depths: 0 where nothing mirrors.
var<workgroup> normals: array<vec2<u32>, SIDE * SIDE>;
var<workgroup> depths: array<f32, SIDE * SIDE>;
/// With a bit for those of rough surfaces, whose rays are further apart.
var<workgroup> hits: array<u32, SIDE * SIDE>;
const IS_ROUGH: u32 = 1u;
/// Light times confidence, and confidence, of 5×5 rays.
var<workgroup> means: array<vec2<u32>, MEANS * MEANS>;

/// 1 if any of them mirrors: all write the same.
var<workgroup> mirrors_any: u32;

struct Receiver {
    /// In pixels.
    at: vec2<f32>,
    depth: f32,
    /// From texel to texel.
    slope: vec2<f32>,
    /// Of the step in depth that separates surfaces a texel apart.
    inverse_step: f32,
    /// In world space.
    normal: vec3<f32>,
    roughness: f32,
}

fn pack_halves(x: vec4<f32>) -> vec2<u32> {
    return vec2(pack2x16float(x.xy), pack2x16float(x.zw));
}

fn unpack_halves(words: vec2<u32>) -> vec4<f32> {
    return vec4(unpack2x16float(words.x), unpack2x16float(words.y));
}

/// How alike the surface of a texel is to one with this normal, which there would have the depth `expected`: 0 to 1.
fn likeness(normal: vec3<f32>, expected: f32, texel: i32, inverse_step: f32) -> f32 {
    let near = saturate(2.0 - abs(depths[texel] - expected) * inverse_step);
    // Without a normal it is like nothing.
    return near * saturate(8.0 * dot(normal, unpack_halves(normals[texel]).xyz) - 7.0);
}

/// How alike the surface of a texel is to the receiver, from which it is `offset` texels away.
fn likeness_of(receiver: Receiver, texel: i32, offset: vec2<f32>) -> f32 {
    let expected = receiver.depth + dot(receiver.slope, offset);
    return likeness(receiver.normal, expected, texel, receiver.inverse_step);
}

/// From texel to texel.
fn slope_at(texel: i32) -> vec2<f32> {
    let depth = depths[texel];
    return vec2(
        flatter_slope(depths[texel - 1], depth, depths[texel + 1]),
        flatter_slope(depths[texel - SIDE], depth, depths[texel + SIDE]),
    );
}

/// How wide a lobe of a roughness squared of 1 is on screen, at so many metres on its way and so far from the camera, in pixels.
fn lobe_width(metres: f32, distance: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return 2.0 * metres * abs(view.pixels_per_metre.y);
#else
    return 2.0 * metres * abs(view.pixels_per_metre.y) / max(distance, 1e-6);
#endif
}

/// What the rays of the texels around have found themselves, for outlines: light times confidence, and confidence.
fn light_around(receiver: Receiver, first: i32, along: vec2<f32>) -> vec4<f32> {
    var sum = vec4(0.0);
    var weights = 1e-12;
    for (var i = 0; i < 4; i++) {
        let corner = vec2<f32>(vec2(i & 1, i >> 1u));
        let texel = first + (i & 1) + SIDE * (i >> 1u);
        // Of rough surfaces a ray beside it may be the only one.
        let near = max(1.0 - abs(corner - along), vec2(1e-3));
        let alike = likeness_of(receiver, texel, corner - along);
        let weight = select(0.0, near.x * near.y * alike, hits[texel] > IS_ROUGH);
        sum += weight * unpack_halves(lights[texel]);
        weights += weight;
    }
    return sum / weights;
}

/// Where a ray is seen: linear in the metres of its way.
struct Line {
    first: vec4<f32>,
    along: vec4<f32>,
}

/// In pixels, and depth.
fn seen_at(line: Line, metres: f32) -> vec3<f32> {
    let seen = line.first + line.along * metres;
    // What is behind the camera is nowhere.
    return select(vec3(-1e9), seen.xyz / seen.w, seen.w > 0.0);
}

/// Whether a surface is there on the way of the pixel's ray: 0 to 1.
fn match_at(receiver: Receiver, at: vec3<f32>) -> f32 {
    let pixel = min(vec2<u32>(at.xy), vec2<u32>(view.viewport_size) - 1u);
    let depth = textureLoad(depth_texture, vec2<u32>(view.viewport_origin) + pixel, 0);
    // What is a pixel away may be the mirror itself, which would see its own light for ever.
    let way = abs(at.xy - receiver.at);
    let is_away = max(way.x, way.y) > 1.5;
    let off = abs(depth - at.z) / max(edge_step(depth, 1.0), 1e-30);
    return select(0.0, saturate(2.0 - off), is_away);
}

/// What ray `i` of the four around the pixel has met: metres on the way of the pixel's own, confidence, and how much it counts.
fn ray_beside(receiver: Receiver, first: i32, i: i32, along: vec2<f32>, distance_to_viewer: f32) -> vec3<f32> {
    let corner = vec2(i & 1, i >> 1u);
    let near = select(1.0 - along, along, corner == vec2(1));
    let texel = first + corner.x + SIDE * corner.y;
    let image = unpack_distance(hits[texel]);
    let alike = near.x * near.y * likeness_of(receiver, texel, vec2<f32>(corner) - along);
    let confidence = unpack2x16float(lights[texel].y).y;
    return vec3(image - distance_to_viewer, confidence, select(0.0, alike, image != 0.0));
}

/// Light times confidence, and confidence.
fn smooth_light(receiver: Receiver, first: i32, along: vec2<f32>) -> vec4<f32> {
    let origin = view_position(receiver.at, receiver.depth);
    let direction = reflect(-to_viewer(origin), rotated(receiver.normal));
#ifdef PROJECTION_ORTHOGRAPHIC
    let distance_to_viewer = 0.0;
#else
    let distance_to_viewer = length(origin);
#endif
    let line = Line(homogeneous_pixel(origin, 1.0), homogeneous_pixel(direction, 0.0));
    // Metres, and confidence.
    var sum = vec2(0.0);
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let ray = ray_beside(receiver, first, i, along, distance_to_viewer);
        sum += ray.xy * ray.z;
        weights += ray.z;
    }
    var mean = sum / max(weights, 1e-6);
    var at = seen_at(line, mean.x);
    // Most often all have met the same surface, and between them the pixel's own ray meets it too.
    if weights > 0.02 && match_at(receiver, at) < 1.0 {
        // Else what those have met on whose surface it is.
        sum = vec2(0.0);
        weights = 0.0;
        for (var i = 0; i < 4; i++) {
            let ray = ray_beside(receiver, first, i, along, distance_to_viewer);
            if ray.z > 0.0 {
                let weight = ray.z * match_at(receiver, seen_at(line, ray.x));
                sum += ray.xy * weight;
                weights += weight;
            }
        }
        mean = sum / max(weights, 1e-6);
        at = seen_at(line, mean.x);
    }
    if !(weights > 0.02) {
        // For outlines.
        return light_around(receiver, first, along);
    }
    let position = origin + direction * mean.x;
    let alpha = receiver.roughness * receiver.roughness;
    let level = log2(max(2.0 * alpha * lobe_width(mean.x, -position.z), 1.0));
    let light = last_light(at, position, level);
    let confidence = mean.y * light.w;
    return vec4(light.rgb * confidence, confidence);
}

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

/// How wide the lobe of a texel is on screen where the rays beside it ended, in pixels, for a roughness squared of 1.
fn width_at(first: i32, position: vec3<f32>) -> f32 {
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0; i < 4; i++) {
        let image = unpack_distance(hits[first + (i & 1) + SIDE * (i >> 1u)]);
        sum += image;
        count += select(0.0, 1.0, image > 0.0);
    }
    let distance = length(position);
#ifdef PROJECTION_ORTHOGRAPHIC
    let begin = 0.0;
#else
    let begin = distance;
#endif
    // Where they met nothing, as wide as if that was as far away as the mirror: what others met further beside is in the lobe of
    // a rough one, and not what a smooth one mirrors.
    let metres = select(distance, sum / max(count, 1.0) - begin, count > 0.0);
    // What is mirrored is about as far away as the mirror: nearer or further is nothing that matters.
    return lobe_width(metres, distance);
}

/// `place` is that of the pixel in the workgroup.
fn light_at(pixel: vec2<i32>, place: vec2<i32>) -> vec4<f32> {
    let depth = depth_in_view(pixel);
    let mirror = mirror_of(pixel, normal_word_at(pixel));
    let fade = smoothness(mirror.roughness) * view.intensity;
    if !(depth > 0.0) || fade == 0.0 {
        return vec4(0.0);
    }
    let texel = vec2<i32>(vec2<u32>(place) / u32(DIVISOR));
    let first = texel.x + SIDE * texel.y + FIRST_MADE;
    var receiver: Receiver;
    receiver.at = vec2<f32>(pixel) + 0.5;
    receiver.depth = depth;
    receiver.normal = mirror.normal;
    receiver.roughness = mirror.roughness;
    receiver.slope = slope_at(first);
    receiver.inverse_step = 1.0 / edge_step(depth, f32(DIVISOR));
    let along = vec2<f32>(vec2<u32>(place) % u32(DIVISOR)) / f32(DIVISOR);
    let alpha = mirror.roughness * mirror.roughness;
    let radius = alpha * width_at(first, view_position(receiver.at, depth));
    let roughness = smoothstep(SMOOTH_UP_TO, ROUGH_FROM, radius);
    var light = vec4(0.0);
    if roughness < 1.0 {
        light += (1.0 - roughness) * smooth_light(receiver, first, along);
    }
    if roughness > 0.0 {
        light += roughness * rough_light(receiver, texel, first, along);
    }
    return vec4(light.rgb / max(light.a, 1e-6), light.a * fade);
}

/// What the textures hold of a texel that the workgroup reads.
struct Texel {
    normal: u32,
    depth: f32,
    light: vec4<f32>,
    hit: u32,
}

/// Where texel `read` of the workgroup is. `corner` is the first one whose pixels it makes.
fn place_of(corner: vec2<i32>, read: i32) -> vec2<i32> {
    return corner + vec2<i32>(vec2(u32(read) % u32(SIDE), u32(read) / u32(SIDE))) - REACH * ROUGH_STEP;
}

/// The nearest one in the picture.
fn nearest_inside(texel: vec2<i32>) -> vec2<i32> {
    return clamp(texel, vec2(0), vec2<i32>(view.texture_size) - 1);
}

fn texel_at(corner: vec2<i32>, read: i32) -> Texel {
    let texel = nearest_inside(place_of(corner, read));
    var known: Texel;
    known.normal = normal_word_at(texel * DIVISOR);
    known.depth = depth_in_view(texel * DIVISOR);
    known.light = textureLoad(rays_texture, texel, 0);
    known.hit = textureLoad(hits_texture, texel, 0).r;
    return known;
}

fn keep(corner: vec2<i32>, read: i32, known: Texel) {
    let texel = place_of(corner, read);
    let mirror = mirror_of(nearest_inside(texel) * DIVISOR, known.normal);
    // What is beyond the rim counts for nothing.
    let counts = all(texel == nearest_inside(texel)) && smoothness(mirror.roughness) > 0.0;
    // Where there is no ray, the textures hold anything.
    let apart = step_of_rays(mirror.roughness);
    let has_ray = counts && known.depth > 0.0 && sends_ray(texel, apart);
    let light = vec4(known.light.rgb * known.light.a, known.light.a);
    lights[read] = select(vec2(0u), pack_halves(light), has_ray);
    hits[read] = select(0u, known.hit, has_ray) | select(0u, IS_ROUGH, apart > 1);
    normals[read] = select(vec2(0u), pack_halves(vec4(mirror.normal, 0.0)), counts);
    depths[read] = select(0.0, known.depth, counts);
    if counts {
        mirrors_any = 1u;
    }
}

@compute @workgroup_size(256, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let i = i32(invocation);
    // Memory holds what ran before.
    if i == 0 {
        mirrors_any = 0u;
    }
    workgroupBarrier();
    let corner = vec2<i32>(workgroup.xy) * TEXELS;
    // Asked for before any is waited for.
    let first = texel_at(corner, i);
    let second = texel_at(corner, i + INVOCATIONS);
    if i + 2 * INVOCATIONS < SIDE * SIDE {
        keep(corner, i + 2 * INVOCATIONS, texel_at(corner, i + 2 * INVOCATIONS));
    }
    keep(corner, i, first);
    if i + INVOCATIONS < SIDE * SIDE {
        keep(corner, i + INVOCATIONS, second);
    }
    let is_empty = workgroupUniformLoad(&mirrors_any) == 0u || view.exposure_ratio == 0.0;
    if !is_empty {
        for (var mean = i; mean < MEANS * MEANS; mean += INVOCATIONS) {
            means[mean] = pack_halves(mean_at(ROUGH_STEP * (mean % MEANS + SIDE * (mean / MEANS)) + FIRST_MADE));
        }
        workgroupBarrier();
    }
    for (var n = i; n < PIXELS * PIXELS; n += INVOCATIONS) {
        let place = vec2<i32>(vec2(u32(n) % u32(PIXELS), u32(n) / u32(PIXELS)));
        let pixel = corner * DIVISOR + place;
        if all(pixel < vec2<i32>(view.viewport_size)) {
            var light = vec4(0.0);
            if !is_empty {
                light = light_at(pixel, place);
            }
            textureStore(output_texture, pixel, light);
        }
    }
}
