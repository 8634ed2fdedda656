// Mirrors, and the light of surfaces in the last frame.
#define_import_path bevy_lean_deferred::effects::reflections::surface

#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, SPECIALIZATION_VALID, unpack_normal, unpack_roughness}
#import bevy_lean_deferred::effects::reflections::bindings::{
    depth_in_view, edge_step, history_sampler, history_texture, motion_texture, normal_texture, specialization_texture,
    valid_mask_texture, view, view_position,
}
#import bevy_lean_deferred::gathered::{interpolated, largest_difference, nearest_of}
#import bevy_lean_deferred::gbuffer::layout::specialization::{
    CLEARCOAT, UNLIT, unpack_arguments, unpack_shading_model,
}
#import bevy_lean_deferred::effects::reprojection::{filled_up, own_motion, weight_of_match}
#import bevy_lean_deferred::shading_models::clearcoat::{unpack_clearcoat_roughness, unpack_clearcoat_strength}

struct Mirror {
    /// In world space.
    normal: vec3<f32>,
    /// Perceptual roughness, of the coat if there is one. Above 1: no mirror.
    roughness: f32,
}

/// Perceptual roughness above which rays march in segments from the start, and lobes are the mean of several frames: between two
/// values of the G-buffer, so that rounding makes no difference.
const ROUGH: f32 = 51.5 / 255.0;

/// Above any roughness.
const NO_MIRROR: f32 = 2.0;

/// Depth steps by which a surface may have moved towards the camera or away from it for each pixel that it moved across on its own: a
/// step is eight pixels deep (`STEEPEST`).
const DEEP_PER_PIXEL: f32 = 0.125;

fn normal_word_at(pixel: vec2<i32>) -> u32 {
    return textureLoad(normal_texture, vec2<i32>(view.viewport_origin) + pixel, 0).r;
}

/// `word` with the roughness of a mirror, which may be that of a coat.
fn with_roughness(word: u32, roughness: f32) -> u32 {
    return (word & 0xffffffu) | (u32(saturate(roughness) * 255.0 + 0.5) << 24u);
}

/// Mirror at a pixel whose normal word has been read already.
fn mirror_of(pixel: vec2<i32>, word: u32) -> Mirror {
    if word == NO_GEOMETRY {
        return Mirror(vec3(0.0, 0.0, 1.0), NO_MIRROR);
    }
    var mirror = Mirror(unpack_normal(word), unpack_roughness(word));
    if view.has_specialization == 0u {
        return mirror;
    }
    let place = vec2<i32>(view.viewport_origin) + pixel;
    if (textureLoad(valid_mask_texture, place, 0).r & SPECIALIZATION_VALID) != 0u {
        let word = textureLoad(specialization_texture, place, 0).r;
        let model = unpack_shading_model(word);
        if model == UNLIT {
            mirror.roughness = NO_MIRROR;
        }
        let arguments = unpack_arguments(word);
        if model == CLEARCOAT && unpack_clearcoat_strength(arguments) > 0.0 {
            mirror.roughness = unpack_clearcoat_roughness(arguments);
        }
    }
    return mirror;
}

/// Rotates a normal to view space.
fn rotated(normal: vec3<f32>) -> vec3<f32> {
    return (view.view_from_world * vec4(normal, 0.0)).xyz;
}

/// Fade of reflections: 1 for smooth surfaces, 0 for those that are too rough.
fn smoothness(roughness: f32) -> f32 {
    return saturate((view.max_roughness - roughness) / max(0.25 * view.max_roughness, 1e-6));
}

/// Width on screen in pixels of a lobe with a squared roughness of 1, after `metres`, at a `distance` from the camera.
fn lobe_width(metres: f32, distance: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return 2.0 * metres * abs(view.pixels_per_metre.y);
#else
    return 2.0 * metres * abs(view.pixels_per_metre.y) / max(distance, 1e-6);
#endif
}

/// Mean light of surfaces around a point of the history, of which levels coarser than 0 are read at another one.
fn mean_light(at: vec2<f32>, coarse_at: vec2<f32>, level: f32) -> vec3<f32> {
    // From level 1 on, alpha is the share of surfaces.
    let coarse = textureSampleLevel(history_texture, history_sampler, coarse_at, max(level, 1.0));
    let mean = coarse.rgb / max(coarse.a, 1e-3);
    if level >= 1.0 {
        return mean;
    }
    let fine = textureSampleLevel(history_texture, history_sampler, at, 0.0).rgb;
    return mix(fine, mean, level);
}

/// Depth steps within which the last frame shows the same surface; a step separates surfaces a pixel apart. Its weight is 0 from
/// twice as many on.
const SAME_SURFACE: f32 = 0.5;

/// Metres that separate surfaces `pixels` apart, `distance` metres away.
fn step_at(distance: f32, pixels: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return view.edge_metres * pixels;
#else
    return abs(distance) * view.edge_metres * pixels;
#endif
}

/// Place of a surface in the last frame.
struct LastPlace {
    /// In pixels of that frame.
    at: vec2<f32>,
    /// Its distances, if it was at rest and if it moved with the camera.
    expected: vec2<f32>,
    /// Metres within which it is the same surface.
    tolerance: f32,
    /// Pixels by which it moved on its own; 0 without motion vectors.
    own: f32,
}

/// Footprint of levels coarser than 0 around a place.
struct Footprint {
    /// Offset in pixels at which they are read.
    shift: vec2<f32>,
    /// True if surfaces behind the place are in it.
    has_further: bool,
}

/// Distance at a point between four texels, of which `around` has the distances: exact if they show a plane.
fn distance_between(around: vec4<f32>, along: vec2<f32>) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return interpolated(around, along);
#else
    // Its inverse is linear on screen.
    return 1.0 / interpolated(1.0 / max(around, vec4(1e-9)), along);
#endif
}

/// Light that the last frame showed at a place of a surface. w: the weight, 0 to 1, with which it is that surface: at one of its distances,
/// or between the two. `level` is that of the history. `blurs_edges`: coarser levels than 0 count at edges, too, but a place with a surface
/// behind it in its footprint is no brighter than its own pixel.
fn kept_light(last: LastPlace, level: f32, blurs_edges: bool, footprint: Footprint) -> vec4<f32> {
    let at = last.at;
    // Half floats have eleven significant bits.
    let tolerance = last.tolerance + 0.001 * max(abs(last.expected.x), abs(last.expected.y));
    let is_inside = all(at >= vec2(0.0)) && all(at < view.last_viewport_size);
    // Distances of the four texels around, gathered at their common corner: near a texel's centre, rounding may select others.
    let first = floor(at - 0.5);
    let along = at - 0.5 - first;
    let around = textureGather(3, history_texture, history_sampler, (first + 1.0) / view.history_size) * view.metres_per_unit;
    let kept = nearest_of(around, along);
    var place = at;
    var used_level = level;
    if level < 1.0 {
        // Interpolates within a surface, else takes the nearest texel.
        let most = largest_difference(around, kept);
        place = select(at, floor(at) + 0.5, most > tolerance);
        used_level = select(level, 0.0, most > tolerance && !blurs_edges);
    }
    let coarse_place = clamp(place + footprint.shift, vec2(0.5), view.last_viewport_size - 0.5);
    var light = mean_light(place / view.history_size, coarse_place / view.history_size, used_level);
    if footprint.has_further && used_level > 0.0 {
        let fine = textureLoad(history_texture, vec2<i32>(at), 0).rgb;
        let is_darker = fine.r + fine.g + fine.b < light.r + light.g + light.b;
        light = select(light, fine, is_darker);
    }
    light *= view.exposure_ratio;
    // At grazing angles, distances within a pixel differ by more than the tolerance: the one between the texels counts, too.
    let between = distance_between(around, along);
    let weight = max(
        weight_of_match(kept, last.expected.x, last.expected.y, tolerance),
        weight_of_match(between, last.expected.x, last.expected.y, tolerance),
    );
    return select(vec4(0.0), vec4(light, weight), is_inside && weight > 0.0);
}

/// Pixel of the last frame where this frame has `pixel`, on a view that may have had another size.
fn with_view(pixel: vec2<f32>) -> vec2<f32> {
    // Signed, for fewer registers: an unsigned size that is converted before a march would stay in them.
    return pixel / vec2<f32>(vec2<i32>(view.viewport_size)) * view.last_viewport_size;
}

/// Motion of a pixel since the last frame, as a share of the picture.
fn motion_at(pixel: vec2<i32>) -> vec2<f32> {
    return textureLoad(motion_texture, vec2<i32>(view.viewport_origin) + pixel, 0).rg;
}

/// Place in the last frame of a surface at `place` (pixels and depth) and `position` (view space) that moved with the camera.
fn carried_place(place: vec3<f32>, position: vec3<f32>) -> LastPlace {
    let distance = -position.z;
    return LastPlace(with_view(place.xy), vec2(distance), step_at(distance, SAME_SURFACE), 0.0);
}

/// Place in the last frame of the surface at `place` (pixels and depth) and `position` (view space).
fn last_place(place: vec3<f32>, position: vec3<f32>) -> LastPlace {
    let last = view.last_pixel_from_view * vec4(position, 1.0);
    // Not behind the camera, nor NaN.
    let was_in_front = last.w > 0.0;
    let at_rest = select(vec2(-1.0), last.xy / last.w, was_in_front);
    let distance_at_rest = dot(view.last_distance, vec4(position, 1.0));
    // A surface that moves with the camera stays where it is.
    let carried = with_view(place.xy);
    let distance = -position.z;
    var at = at_rest;
    var expected = vec2(distance_at_rest);
    var metres = step_at(distance_at_rest, SAME_SURFACE);
    var own = 0.0;
    if view.has_motion != 0u {
        let pixel = clamp(vec2<i32>(place.xy), vec2(0), vec2<i32>(view.viewport_size) - 1);
        at = carried - motion_at(pixel) * view.last_viewport_size;
        expected = vec2(select(distance, distance_at_rest, was_in_front), distance);
        // A surface that moves on its own may also come nearer or move away: by less than `thickness`, which is twice the tolerance.
        own = own_motion(at, at_rest, carried);
        metres = step_at(distance, SAME_SURFACE + DEEP_PER_PIXEL * own) + 0.5 * view.thickness;
    }
    // At rest, surfaces that were behind the camera are outside of the view: `at` is negative.
    return LastPlace(at, expected, metres, own);
}

/// Pixels per frame from which on a surface counts as moving on its own. Motion vectors are rounded.
const LEAST_OWN: f32 = 0.25;

/// True for a surface that moves on its own.
fn moves_itself(place: vec3<f32>, position: vec3<f32>) -> bool {
    return last_place(place, position).own > LEAST_OWN;
}

/// Stand-ins for a place of a surface that the last frame did not show.
const STAND_INS: i32 = 3;

/// Pixels up to which the tolerance of a stand-in's depth grows with its distance on screen.
const FAR: f32 = 8.0;

/// Stand-in `i`: another place at the same depth, along the motion of the surface on screen. Its distance from the place, relative to
/// that motion, is 1 behind an edge that moves faster than the surface, -1 (the same pixel) behind one that moves more slowly, or 4,
/// beyond a narrow thing. `own` is its distance from the place, in pixels.
fn stand_in(last: LastPlace, place: vec3<f32>, i: i32) -> LastPlace {
    let motion = last.at - with_view(place.xy);
    let multiple = select(select(4.0, -1.0, i == 1), 1.0, i == 0);
    let at = clamp(last.at + multiple * motion, vec2(0.5), view.last_viewport_size - 0.5);
    let far = distance(at, last.at);
    let deeper = step_at(last.expected.y, DEEP_PER_PIXEL * min(far, FAR));
    return LastPlace(at, last.expected, last.tolerance + deeper, far);
}

/// Level up to which outlines are followed: those further away are of other things.
const LAST_FOLLOWED: f32 = 4.0;

/// Least bend of the depths around a place that has another surface behind it, as a share of the step that separates surfaces as far apart.
const BENT: f32 = 0.25;

/// Footprint around `place`, as four surfaces show it, a texel of the level (at most 16 pixels) away along each axis. Its offset is the
/// motion of the nearest of them minus that of `place` itself, or 0 if none of them is nearer. Coarse levels blur the surfaces of the last
/// frame; at this offset, the outline of the nearest one is where this frame has it (dilation as in Karis 2014, "High-Quality Temporal
/// Supersampling").
fn footprint_of(last: LastPlace, place: vec3<f32>, level: f32) -> Footprint {
    if level <= 0.0 {
        return Footprint(vec2(0.0), false);
    }
    let pixel = vec2<i32>(place.xy);
    let far = i32(ceil(exp2(clamp(level, 1.0, LAST_FOLLOWED))));
    let depths = vec4(
        depth_in_view(pixel + vec2(far, 0)), depth_in_view(pixel - vec2(far, 0)),
        depth_in_view(pixel + vec2(0, far)), depth_in_view(pixel - vec2(0, far)),
    );
    let nearest = max(max(depths.x, depths.y), max(depths.z, depths.w));
    let tolerance = edge_step(place.z, f32(far));
    // Depths of a plane are linear on screen. Nothing is known beyond the picture, and the sky is not in coarse levels.
    let bends = 2.0 * depth_in_view(pixel) - vec2(depths.x + depths.y, depths.z + depths.w);
    let is_inside = (pixel >= vec2(far)) & (pixel < vec2<i32>(view.viewport_size) - far);
    let are_surfaces = min(depths.xz, depths.yw) > vec2(0.0);
    let has_further = any(is_inside & are_surfaces & (bends > vec2(BENT * tolerance)));
    // Without motion vectors, all that is known to move is what the camera's motion displaces.
    let is_at_rest = view.has_motion == 0u && view.carries_surfaces == 0u;
    if is_at_rest || nearest <= place.z + tolerance {
        return Footprint(vec2(0.0), has_further);
    }
    let is_horizontal = any(depths.xy == vec2(nearest));
    let is_first = select(depths.z, depths.x, is_horizontal) == nearest;
    let step = select(vec2(0, far), vec2(far, 0), is_horizontal);
    let other = clamp(select(pixel - step, pixel + step, is_first), vec2(0), vec2<i32>(view.viewport_size) - 1);
    let there = vec3(vec2<f32>(other) + 0.5, nearest);
    let motion = last_place(there, view_position(there.xy, nearest)).at - with_view(there.xy);
    let shift = motion - (last.at - with_view(place.xy));
    // Further away, the last frame shows another part of the place's own surface.
    let share = saturate(2.0 - length(shift) / f32(far));
    return Footprint(select(vec2(0.0), shift * share, share > 0.0), has_further);
}

/// Light in the last frame of the surface at `place` (pixels and depth) and `position` (view space). w: the weight, 0 to 1, with
/// which that frame showed it. `level` and `blurs_edges` are those of `kept_light`.
fn last_light(place: vec3<f32>, position: vec3<f32>, level: f32, blurs_edges: bool) -> vec4<f32> {
    let last = last_place(place, position);
    var footprint = footprint_of(last, place, level);
    var light = kept_light(last, level, blurs_edges, footprint);
    // Other places are beyond the outline already.
    footprint.shift = vec2(0.0);
    if view.has_motion != 0u {
        for (var i = 0; i < STAND_INS && light.w < 1.0; i++) {
            let other = stand_in(last, place, i);
            var found = kept_light(other, level, blurs_edges, footprint);
            // At rest it is the same place.
            found.w *= saturate(other.own);
            light = filled_up(light, found);
        }
    } else if view.carries_surfaces != 0u && light.w < 1.0 {
        light = filled_up(light, kept_light(carried_place(place, position), level, blurs_edges, footprint));
    }
    return light;
}
