// Reflection of a smooth surface: the light at the end of the pixel's own ray, which is as long as those beside it.
#define_import_path bevy_lean_deferred::effects::reflections::smooth_light

#import bevy_lean_deferred::effects::reflections::bindings::{
    depth_texture, edge_step, homogeneous_pixel, to_viewer, unpack_distance, view, view_position,
}
#import bevy_lean_deferred::effects::reflections::mirrored_light::mirrored_light
#import bevy_lean_deferred::effects::reflections::receiver::{
    Receiver, light_around, steady_hit, texel_beside,
}
#import bevy_lean_deferred::effects::reflections::surface::{lobe_width, rotated}
#import bevy_lean_deferred::effects::reflections::texels::{first_beside, lights}

/// Gap where no surface is to be tested.
const NOTHING_NEAR: f32 = 9.0;
/// Iterations of the search between two rays.
const NARROWINGS: i32 = 3;
/// Spread of the lengths of rays that hit one surface, relative to the longest.
const SPREAD: f32 = 0.2;

/// Hit of a ray beside the pixel.
struct NeighborRay {
    /// Distance along the pixel's own ray; 0 for a miss.
    metres: f32,
    confidence: f32,
    /// Interpolation weight; 0 for a miss.
    weight: f32,
    /// True if it belongs to the same mirror.
    is_alike: bool,
}

/// Reflection of a pixel.
struct SmoothLight {
    /// Light times confidence, and confidence, as if the last frame had shown all of it: see `known`.
    light: vec4<f32>,
    /// True if the pixel's own ray hits a surface of one of the rays around that do not change.
    is_met: bool,
    /// True if the rays around hit one surface, and the pixel's own ray hits it too.
    is_certain: bool,
    /// Share of the light at its hit that the last frame showed; 1 for a miss.
    known: f32,
}

/// The pixel's own ray on screen, in pixels and depth: `start + along.xyz * metres / (1 + along.w * metres)`.
struct Line {
    start: vec3<f32>,
    along: vec4<f32>,
}

fn line_from(start: vec3<f32>, origin: vec3<f32>, direction: vec3<f32>) -> Line {
    let here = homogeneous_pixel(origin, 1.0).w;
    let towards = homogeneous_pixel(direction, 0.0);
    return Line(start, vec4(towards.xyz - start * towards.w, towards.w) / here);
}

/// In pixels, and depth.
fn seen_at(line: Line, metres: f32) -> vec3<f32> {
    let scale = 1.0 + line.along.w * metres;
    // Points behind the camera are off-screen.
    return select(vec3(-1e9), line.start + line.along.xyz * (metres / scale), scale > 0.0);
}

/// Gap by which the pixel's ray is in front of the visible surface at `at`, in depth steps of surfaces a pixel apart.
fn gap_at(receiver: Receiver, at: vec3<f32>) -> f32 {
    // Like `depth_in_view`, in fewer instructions: negative values become 0 in the conversion to unsigned.
    let pixel = min(vec2<u32>(at.xy), vec2<u32>(view.viewport_size) - 1u);
    let depth = textureLoad(depth_texture, vec2<u32>(view.viewport_origin) + pixel, 0);
    // An adjacent pixel may be the mirror itself, which would keep its own light forever.
    let state = abs(at.xy - receiver.at);
    let is_away = max(state.x, state.y) > 1.5;
    return select(NOTHING_NEAR, (at.z - depth) / max(edge_step(depth, 1.0), 1e-30), is_away);
}

/// Match of the ray with a surface, 0 to 1.
fn match_of(gap: f32) -> f32 {
    return saturate(2.0 - abs(gap));
}

/// Distance in metres at which the pixel's ray hits a surface between `front`, where it is in front of the visible surface, and
/// `back`, where it is behind it: metres and gap each (regula falsi). Negative for a miss.
fn metres_between(receiver: Receiver, line: Line, front: vec2<f32>, back: vec2<f32>) -> f32 {
    var before = front;
    var after = back;
    for (var i = 0; i < NARROWINGS && 0.0 <= before.x && before.x < after.x; i++) {
        let share = clamp(before.y / (before.y - after.y), 0.1, 0.9);
        let metres = mix(before.x, after.x, share);
        let gap = gap_at(receiver, seen_at(line, metres));
        if match_of(gap) > 0.5 {
            return metres;
        }
        if gap > 0.0 {
            before = vec2(metres, gap);
        } else {
            after = vec2(metres, gap);
        }
    }
    return -1.0;
}

/// Hit of ray `i` of the four around the pixel.
fn neighbor_ray(receiver: Receiver, first: i32, i: i32, distance_to_viewer: f32) -> NeighborRay {
    let texel = texel_beside(first, i);
    let image = unpack_distance(steady_hit(texel));
    let has_met = image != 0.0;
    return NeighborRay(
        select(0.0, image - distance_to_viewer, has_met),
        unpack2x16float(lights[texel].y).y,
        select(0.0, receiver.weights[i], has_met && receiver.is_near[i]),
        receiver.is_alike[i],
    );
}

/// Hit of the pixel's ray where those beside it hit different surfaces: on one of these, or on one that curves between them. Metres,
/// confidence and weight; on a curved one, `confidence`, the mean of all rays.
fn place_of_some(
    receiver: Receiver,
    line: Line,
    first: i32,
    distance_to_viewer: f32,
    confidence: f32,
) -> vec3<f32> {
    var sum = vec2(0.0);
    var weights = 0.0;
    // The last point in front of the visible surface, and the first one behind it: metres and gap.
    var front = vec2(-1.0, 0.0);
    var back = vec2(0.0);
    for (var i = 0; i < 4; i++) {
        let ray = neighbor_ray(receiver, first, i, distance_to_viewer);
        if ray.weight > 0.0 {
            let gap = gap_at(receiver, seen_at(line, ray.metres));
            let weight = ray.weight * match_of(gap);
            sum += vec2(ray.metres, ray.confidence) * weight;
            weights += weight;
            if gap > 0.0 && ray.metres > front.x {
                front = vec2(ray.metres, gap);
            }
            if gap <= 0.0 && (back.x == 0.0 || ray.metres < back.x) {
                back = vec2(ray.metres, gap);
            }
        }
    }
    let mean = sum / max(weights, 1e-6);
    if weights > 0.02 && match_of(gap_at(receiver, seen_at(line, mean.x))) > 0.5 {
        return vec3(mean, weights);
    }
    let metres = metres_between(receiver, line, front, back);
    return vec3(metres, confidence, select(0.0, 1.0, metres >= 0.0));
}

fn smooth_light(receiver: Receiver, first: i32) -> SmoothLight {
    let origin = view_position(receiver.at, receiver.depth);
    let direction = reflect(-to_viewer(origin), rotated(receiver.normal));
    let to_mirror = length(origin);
#ifdef PROJECTION_ORTHOGRAPHIC
    let distance_to_viewer = 0.0;
#else
    let distance_to_viewer = to_mirror;
#endif
    let line = line_from(vec3(receiver.at, receiver.depth), origin, direction);
    // Metres, and confidence.
    var sum = vec2(0.0);
    var weights = 0.0;
    var shortest = 1e9;
    var longest = 0.0;
    for (var i = 0; i < 4; i++) {
        let ray = neighbor_ray(receiver, first, i, distance_to_viewer);
        sum += vec2(ray.metres, ray.confidence) * ray.weight;
        weights += ray.weight;
        shortest = select(shortest, min(shortest, ray.metres), ray.is_alike);
        longest = select(longest, max(longest, ray.metres), ray.is_alike);
    }
    var mean = sum / max(weights, 1e-6);
    var at = seen_at(line, mean.x);
    let is_one = longest - shortest < SPREAD * longest;
    // Most often all rays have hit the same surface, and the pixel's own ray hits it between them.
    let is_met = weights > 0.02 && match_of(gap_at(receiver, at)) == 1.0;
    let is_certain = is_met && is_one;
    var is_hit = weights > 0.02;
    if is_hit && !is_met {
        let place = place_of_some(receiver, line, first, distance_to_viewer, mean.y);
        mean = place.xy;
        is_hit = place.z > 0.02;
        at = seen_at(line, mean.x);
    }
    if !is_hit {
        // At silhouettes. Not `first`: what was read of these texels before would be in registers until here.
        return SmoothLight(light_around(receiver, first_beside(receiver.at)), false, false, 1.0);
    }
    // Not `origin + direction * mean.x`: six registers less are in use until here.
    let position = view_position(at.xy, at.z);
    let alpha = receiver.roughness * receiver.roughness;
    let level = log2(max(2.0 * alpha * lobe_width(mean.x, -position.z), 1.0));
    let light = mirrored_light(at, position, level, true, to_mirror, mean.x);
    return SmoothLight(vec4(light.rgb, 1.0) * mean.y, true, is_certain, light.w);
}
