// Mirrors, and the light of surfaces in the last frame.
#define_import_path bevy_lean_deferred::effects::reflections::surface

#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, SPECIALIZATION_VALID, unpack_normal, unpack_roughness}
#import bevy_lean_deferred::effects::reflections::bindings::{
    history_sampler, history_texture, motion_texture, normal_texture, specialization_texture, valid_mask_texture, view,
}
#import bevy_lean_deferred::gbuffer::layout::specialization::{
    CLEARCOAT, UNLIT, unpack_arguments, unpack_shading_model,
}
#import bevy_lean_deferred::shading_models::clearcoat::{unpack_clearcoat_roughness, unpack_clearcoat_strength}

struct Mirror {
    /// In world space.
    normal: vec3<f32>,
    /// Perceptual roughness, of the coat if there is one. Above 1: no mirror.
    roughness: f32,
}

/// Above any roughness.
const NO_MIRROR: f32 = 2.0;

fn normal_word_at(pixel: vec2<i32>) -> u32 {
    return textureLoad(normal_texture, vec2<i32>(view.viewport_origin) + pixel, 0).r;
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

/// Mean light of surfaces around a point of the history.
fn mean_light(at: vec2<f32>, level: f32) -> vec3<f32> {
    // From level 1 on, alpha is the share of surfaces.
    let coarse = textureSampleLevel(history_texture, history_sampler, at, max(level, 1.0));
    let mean = coarse.rgb / max(coarse.a, 1e-3);
    if level >= 1.0 {
        return mean;
    }
    let fine = textureSampleLevel(history_texture, history_sampler, at, 0.0).rgb;
    return mix(fine, mean, level);
}

/// Light in the last frame of the surface at `place` (pixels and depth) and `position` (view space). w is 1, or 0 if that frame did
/// not show it. `level` is that of the history.
fn last_light(place: vec3<f32>, position: vec3<f32>, level: f32) -> vec4<f32> {
    let last = view.last_pixel_from_view * vec4(position, 1.0);
    // Behind the camera, or NaN.
    if !(last.w > 0.0) {
        return vec4(0.0);
    }
    var at = last.xy / last.w;
    let distance = dot(view.last_distance, vec4(position, 1.0));
#ifdef PROJECTION_ORTHOGRAPHIC
    var tolerance = view.edge_metres;
#else
    var tolerance = abs(distance) * view.edge_metres;
#endif
    if view.has_motion != 0u {
        let pixel = clamp(vec2<i32>(place.xy), vec2(0), vec2<i32>(view.viewport_size) - 1);
        let motion = textureLoad(motion_texture, vec2<i32>(view.viewport_origin) + pixel, 0).rg;
        at = place.xy - motion * vec2<f32>(view.viewport_size);
        // The surface may have come nearer.
        tolerance += view.thickness;
    }
    let is_inside = all(at >= vec2(0.0)) && all(at < vec2<f32>(view.viewport_size));
    // Distances of the four texels around, gathered at their common corner: near a texel's centre, rounding may select others.
    let first = floor(at - 0.5);
    let is_second = at - 0.5 - first >= vec2(0.5);
    let around = textureGather(3, history_texture, history_sampler, (first + 1.0) / view.history_size) * view.metres_per_unit;
    let kept = select(select(around.w, around.z, is_second.x), select(around.x, around.y, is_second.x), is_second.y);
    // Half floats have eleven significant bits.
    let rounding = 0.002 * abs(distance);
    if level < 1.0 {
        // Interpolates within a surface, else takes the nearest texel.
        let off = abs(around - kept);
        let most = max(max(off.x, off.y), max(off.z, off.w));
        at = select(at, floor(at) + 0.5, most > tolerance + rounding);
    }
    let light = mean_light(at / view.history_size, level);
    let is_seen = is_inside && abs(kept - distance) <= tolerance + rounding;
    return select(vec4(0.0), vec4(light * view.exposure_ratio, 1.0), is_seen);
}
