// What each pixel mirrors, of what the rays around it have found. A rough mirror has the mean of sixteen, which make a lobe
// together. A smooth one has the light of one place: where its own ray ends, as far away as those beside it went.
#import bevy_lean_deferred::screen_space::reflections::bindings::{
    DIVISOR, depth_in_view, edge_step, flatter, hits_texture, output_texture, rays_texture, to_viewer, unpack_hit,
    view, view_position,
}
#import bevy_lean_deferred::screen_space::reflections::surface::{last_light, mirror_at, smoothness}

/// Texels a side that a workgroup reads: those of its 8×8 pixels, one before and two after.
const SIDE: i32 = 8 / DIVISOR + 3;

/// Radius of a lobe where it meets a surface, in pixels, up to which it is taken for a single place, and from which on it
/// is the mean of rays.
const SMOOTH_UP_TO: f32 = 2.0;
const ROUGH_FROM: f32 = 8.0;

var<workgroup> lights: array<vec4<f32>, #{SIDE_SQUARED}>;
/// Normal, and depth: 0 where nothing mirrors.
var<workgroup> mirrors: array<vec4<f32>, #{SIDE_SQUARED}>;
var<workgroup> hits: array<u32, #{SIDE_SQUARED}>;

struct Receiver {
    at: vec2<f32>,
    depth: f32,
    /// From texel to texel.
    slope: vec2<f32>,
    position: vec3<f32>,
    normal: vec3<f32>,
    roughness: f32,
}

/// How alike the surface of a texel is, 0 to 1; `offset` texels away from the receiver.
fn likeness(receiver: Receiver, other: vec4<f32>, offset: vec2<f32>) -> f32 {
    let expected = receiver.depth + dot(receiver.slope, offset);
    let near = saturate(2.0 - abs(other.w - expected) / edge_step(receiver.depth, f32(DIVISOR)));
    let parallel = saturate(8.0 * dot(receiver.normal, other.xyz) - 7.0);
    return select(near * parallel, 0.0, other.w == 0.0);
}

/// How wide a lobe of roughness `alpha` is on screen, at so many metres on its way, in pixels.
fn lobe_radius(alpha: f32, metres: f32, distance: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return 2.0 * alpha * metres * abs(view.pixels_per_metre.y);
#else
    return 2.0 * alpha * metres * abs(view.pixels_per_metre.y) / max(distance, 1e-6);
#endif
}

/// How far a mirror image is behind the mirror, in metres.
fn metres_of(receiver: Receiver, inverse_distance: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return 1.0 / inverse_distance;
#else
    return 1.0 / inverse_distance - length(receiver.position);
#endif
}

/// Light times confidence, and confidence.
fn smooth_light(receiver: Receiver, first: i32, along: vec2<f32>) -> vec4<f32> {
    let direction = reflect(-to_viewer(receiver.position), receiver.normal);
    let alpha = receiver.roughness * receiver.roughness;
    var sum = vec4(0.0);
    var weights = 0.0;
    // What they have found themselves, for outlines.
    var around = vec4(0.0);
    var weights_around = 1e-6;
    for (var i = 0; i < 4; i++) {
        let corner = vec2(i & 1, i >> 1u);
        let near = select(1.0 - along, along, corner == vec2(1));
        let texel = first + corner.x + SIDE * corner.y;
        let hit = unpack_hit(hits[texel]);
        let alike = near.x * near.y * likeness(receiver, mirrors[texel], vec2<f32>(corner) - along);
        let found = lights[texel];
        around += alike * vec4(found.rgb * found.a, found.a);
        weights_around += alike;
        if alike == 0.0 || hit.inverse_distance == 0.0 {
            continue;
        }
        // Is a surface there on the way of this pixel's ray?
        let position = receiver.position + direction * metres_of(receiver, hit.inverse_distance);
        let seen = view.pixel_from_view * vec4(position, 1.0);
        if !(seen.w > 0.0) {
            continue;
        }
        let at = seen.xyz / seen.w;
        let depth = depth_in_view(vec2<i32>(floor(at.xy)));
        let step = edge_step(depth, 1.0);
        let match_weight = alike * saturate(2.0 - abs(depth - at.z) / max(step, 1e-30));
        sum += vec4(position, found.a) * match_weight;
        weights += match_weight;
    }
    if !(weights > 0.02) {
        return around / weights_around;
    }
    let mean = sum / weights;
    let seen = view.pixel_from_view * vec4(mean.xyz, 1.0);
    let at = seen.xyz / seen.w;
    let metres = distance(mean.xyz, receiver.position);
    let level = log2(max(2.0 * lobe_radius(alpha, metres, -mean.z), 1.0));
    let light = last_light(at, mean.xyz, level);
    let confidence = mean.w * light.w;
    return vec4(light.rgb * confidence, confidence);
}

/// Light times confidence, and confidence.
fn rough_light(receiver: Receiver, first: i32, along: vec2<f32>) -> vec4<f32> {
    var sum = vec4(0.0);
    var weights = 0.0;
    for (var y = -1; y <= 2; y++) {
        for (var x = -1; x <= 2; x++) {
            let texel = first + x + SIDE * y;
            let alike = likeness(receiver, mirrors[texel], vec2(f32(x), f32(y)) - along);
            let weight = alike * unpack_hit(hits[texel]).weight;
            let light = lights[texel];
            sum += weight * vec4(light.rgb * light.a, light.a);
            weights += weight;
        }
    }
    return sum / max(weights, 1e-6);
}

/// How wide the lobe is on screen where the rays beside it ended, in pixels.
fn radius_at(receiver: Receiver, first: i32) -> f32 {
    let alpha = receiver.roughness * receiver.roughness;
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0; i < 4; i++) {
        let hit = unpack_hit(hits[first + (i & 1) + SIDE * (i >> 1u)]);
        if hit.inverse_distance > 0.0 {
            let metres = metres_of(receiver, hit.inverse_distance);
            // What is mirrored is about as far away as the mirror: nearer or further is nothing that matters.
            sum += lobe_radius(alpha, metres, length(receiver.position));
            count += 1.0;
        }
    }
    return select(1e9, sum / max(count, 1.0), count > 0.0);
}

fn light_at(pixel: vec2<i32>, place: vec2<i32>) -> vec4<f32> {
    let texel = place / DIVISOR;
    let center = (texel.x + 1) + SIDE * (texel.y + 1);
    var receiver: Receiver;
    receiver.depth = depth_in_view(pixel);
    if !(receiver.depth > 0.0) || view.exposure_ratio == 0.0 {
        return vec4(0.0);
    }
    let mirror = mirror_at(pixel);
    let fade = smoothness(mirror.roughness) * view.intensity;
    if fade == 0.0 {
        return vec4(0.0);
    }
    receiver.at = vec2<f32>(pixel) + 0.5;
    receiver.normal = mirror.normal;
    receiver.roughness = mirror.roughness;
    receiver.position = view_position(receiver.at, receiver.depth);
    let slope = vec2(
        flatter(mirrors[center - 1].w, mirrors[center].w, mirrors[center + 1].w),
        flatter(mirrors[center - SIDE].w, mirrors[center].w, mirrors[center + SIDE].w),
    );
    receiver.slope = slope;
    let along = vec2<f32>(place % DIVISOR) / f32(DIVISOR);
    let radius = radius_at(receiver, center);
    let roughness = smoothstep(SMOOTH_UP_TO, ROUGH_FROM, radius);
    var light = vec4(0.0);
    if roughness < 1.0 {
        light += (1.0 - roughness) * smooth_light(receiver, center, along);
    }
    if roughness > 0.0 {
        light += roughness * rough_light(receiver, center, along);
    }
    return vec4(light.rgb / max(light.a, 1e-6), light.a * fade);
}

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    let corner = vec2<i32>(workgroup.xy) * (8 / DIVISOR) - 1;
    let last = vec2<i32>(view.texture_size) - 1;
    for (var read = i32(i); read < SIDE * SIDE; read += 64) {
        let texel = corner + vec2(read % SIDE, read / SIDE);
        let inside = clamp(texel, vec2(0), last);
        let hit = textureLoad(hits_texture, inside, 0).r;
        let mirror = mirror_at(inside * DIVISOR);
        lights[read] = textureLoad(rays_texture, inside, 0);
        hits[read] = hit;
        // What is beyond the rim counts for nothing.
        let counts = all(texel == inside) && smoothness(mirror.roughness) > 0.0;
        mirrors[read] = vec4(mirror.normal, select(0.0, depth_in_view(inside * DIVISOR), counts));
    }
    workgroupBarrier();
    let place = vec2<i32>(vec2(i % 8u, i / 8u));
    let pixel = vec2<i32>(workgroup.xy) * 8 + place;
    if all(pixel < vec2<i32>(view.viewport_size)) {
        textureStore(output_texture, pixel, light_at(pixel, place));
    }
}
