// The pixel to be resolved, and the results of the rays of the texels around it.
#define_import_path bevy_lean_deferred::effects::reflections::receiver

#import bevy_lean_deferred::gbuffer::layout::light::unpack_halves
#import bevy_lean_deferred::effects::reflections::bindings::{CHANGES, unpack_distance, view}
#import bevy_lean_deferred::effects::reflections::surface::{Mirror, ROUGH, lobe_width}
#import bevy_lean_deferred::effects::reflections::texels::{
    CACHE_SIDE, depths, hits, inverse_step_at, likeness, lights, normals, slope_at,
}

struct Receiver {
    /// Position in pixels.
    at: vec2<f32>,
    depth: f32,
    /// In world space.
    normal: vec3<f32>,
    roughness: f32,
    /// Interpolation weights of the four texels around it, by distance and likeness. Above 0 for the furthest, too: it may be the only
    /// one of its surface.
    weights: vec4<f32>,
    /// True for texels of the same mirror.
    is_alike: vec4<bool>,
    /// False for texels that would have no weight by distance alone: the pixel is in the row or column of others.
    is_near: vec4<bool>,
}

/// Index of texel `i` of the four around the pixel, of which `first` is the first.
fn texel_beside(first: i32, i: i32) -> i32 {
    return first + (i & 1) + CACHE_SIDE * (i >> 1u);
}

/// Receiver at a position in pixels, which is `along` of the way between the texels around it.
fn receiver_at(at: vec2<f32>, depth: f32, mirror: Mirror, first: i32, along: vec2<f32>) -> Receiver {
    var receiver: Receiver;
    receiver.at = at;
    receiver.depth = depth;
    receiver.normal = mirror.normal;
    receiver.roughness = mirror.roughness;
    let slope = slope_at(first);
    let inverse_step = inverse_step_at(depth);
    for (var i = 0; i < 4; i++) {
        let corner = vec2(i & 1, i >> 1u);
        let expected = depth + dot(slope, vec2<f32>(corner) - along);
        let alike = likeness(mirror.normal, expected, texel_beside(first, i), inverse_step);
        let near = select(1.0 - along, max(along, vec2(1e-3)), corner == vec2(1));
        receiver.weights[i] = near.x * near.y * alike;
        receiver.is_alike[i] = alike > 0.5;
        receiver.is_near[i] = all(corner == vec2(0) | along > vec2(0.0));
    }
    return receiver;
}

/// Hit of a ray; 0 if the ray changes from frame to frame.
fn steady_hit(texel: i32) -> u32 {
    let hit = hits[texel];
    return select(hit, 0u, (hit & CHANGES) != 0u);
}

/// Rays beside a pixel of a smooth surface.
struct Beside {
    /// Width on screen in pixels of the lobe at the hits of those that do not change, for a squared roughness of 1.
    width: f32,
    /// True if one of these hits something.
    has_hit: bool,
    /// True if a ray of the pixel's surface changes, except for those of rough surfaces in the same plane.
    changes: bool,
}

fn rays_beside(receiver: Receiver, first: i32, position: vec3<f32>) -> Beside {
    var sum = 0.0;
    var count = 0.0;
    var changes = false;
    for (var i = 0; i < 4; i++) {
        let texel = texel_beside(first, i);
        let image = unpack_distance(steady_hit(texel));
        sum += image;
        count += select(0.0, 1.0, image > 0.0);
        let is_smooth = unpack_halves(normals[texel]).w <= ROUGH;
        changes |= is_smooth && receiver.weights[i] > 0.0 && (hits[texel] & CHANGES) != 0u;
    }
    let distance = length(position);
#ifdef PROJECTION_ORTHOGRAPHIC
    let begin = 0.0;
#else
    let begin = distance;
#endif
    // Without hits, assumes one as far away as the mirror: hits of rays further away are part of a rough mirror's lobe, but not of
    // a smooth mirror's reflection.
    let metres = select(distance, sum / max(count, 1.0) - begin, count > 0.0);
    // The hit is assumed at the mirror's distance from the camera, which is accurate enough.
    return Beside(lobe_width(metres, distance), count > 0.0, changes);
}

/// Sum of weights up to which no texel around a pixel counts as one of its surface.
const NONE_ALIKE: f32 = 1e-3;

/// Light of the rays around, for silhouettes: light times confidence, and confidence.
fn light_around(receiver: Receiver, first: i32) -> vec4<f32> {
    var sum = vec4(0.0);
    var weights = 1e-12;
    for (var i = 0; i < 4; i++) {
        let texel = texel_beside(first, i);
        let weight = select(0.0, receiver.weights[i], steady_hit(texel) != 0u);
        sum += weight * unpack_halves(lights[texel]);
        weights += weight;
    }
    if weights < NONE_ALIKE {
        return light_of_least_different(receiver, first);
    }
    return sum / weights;
}

/// The same where no texel around is of the pixel's surface, as on thin or strongly curved mirrors: light of the ray whose surface
/// differs least.
fn light_of_least_different(receiver: Receiver, first: i32) -> vec4<f32> {
    let inverse_step = inverse_step_at(receiver.depth);
    var light = vec4(0.0);
    var most = 0.0;
    for (var i = 0; i < 4; i++) {
        let texel = texel_beside(first, i);
        let off = (depths[texel] - receiver.depth) * inverse_step;
        let facing = saturate(dot(receiver.normal, unpack_halves(normals[texel]).xyz));
        let alike = select(0.0, facing / (1.0 + off * off), steady_hit(texel) != 0u);
        if alike > most {
            most = alike;
            light = unpack_halves(lights[texel]);
        }
    }
    return light;
}
