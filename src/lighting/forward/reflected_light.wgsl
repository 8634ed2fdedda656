// The picture in the mirror of a forward mesh, also for shaders of apps.
#define_import_path bevy_lean_deferred::lighting::forward::reflected_light

#ifdef FORWARD_REFLECTIONS
#import bevy_lean_deferred::distance_fog::{CLEAR, fogged_in_mirror, without_fog}
#import bevy_lean_deferred::gbuffer::layout::is_finite
#import bevy_lean_deferred::lighting::forward::bindings::reflections
#import bevy_lean_deferred::lighting::forward::last_frame::{
    is_in_last_view, kept_light, kept_surface, last_pixel, last_ray,
}
#import bevy_lean_deferred::lighting::forward::march::{march, ray_from}
#import bevy_lean_deferred::screen_ray::{metres_at, rim_fade}

/// Fade of reflections: 1 for smooth surfaces, 0 for those that are too rough.
fn smoothness(roughness: f32) -> f32 {
    return saturate((reflections.max_roughness - roughness) / max(0.25 * reflections.max_roughness, 1e-6));
}

/// Light that the surface at `position` (world space, metres) with the unit `normal` (world space, on the side of the viewer) mirrors from
/// the last frame. `roughness` is perceptual, 0 to 1: the rougher, the more of the picture is averaged around the end of the one ray.
///
/// rgb: radiance from the mirrored direction, exposed as the picture is, 0 to 65504, and with the fog between mirror and mirrored surface.
/// a: confidence, 0 to 1. The rest is for what else the surface mirrors, such as an environment map. All are 0 where the ray finds no
/// surface in the picture, and for views and devices without reflections on forward meshes. Fresnel's terms are the caller's.
fn lean_reflected_light(position: vec3<f32>, normal: vec3<f32>, roughness: f32) -> vec4<f32> {
    let fade = smoothness(roughness) * reflections.intensity;
    if reflections.exposure_ratio == 0.0 || fade == 0.0 {
        return vec4(0.0);
    }
    let origin = (reflections.view_from_world * vec4(position, 1.0)).xyz;
    let N = (reflections.view_from_world * vec4(normal, 0.0)).xyz;
    let to_viewer = select(normalize(-origin), vec3(0.0, 0.0, 1.0), reflections.is_orthographic == 1u);
    let direction = reflect(-to_viewer, N);
    // Shading normals may lean away from the viewer: then the ray would enter the surface.
    if !(dot(direction, N) > 0.0) {
        return vec4(0.0);
    }
    let ray = ray_from(origin, direction);
    let last = last_ray(origin, direction);
    let hit = march(ray, last);
    if !hit.is_hit {
        return vec4(0.0);
    }
    let metres = metres_at(ray, hit.u);
    let at = last_pixel(last, metres);
    let met = origin + direction * metres;
    let distance = select(max(-met.z, 1e-6), 1.0, reflections.is_orthographic == 1u);
    let width = 4.0 * roughness * roughness * metres * reflections.pixels_per_metre / distance;
    let level = log2(max(width, 1.0));
    var light = kept_light(select(at, kept_surface(at).place, level < 1.0), level);
    if reflections.fog.mode != CLEAR {
        // Lighting adds the fog in front of the mirror.
        light = without_fog(reflections.fog, light, length(met), reflections.exposure_ratio);
        light = fogged_in_mirror(reflections.fog, light, length(origin), length(origin) + metres);
    }
    let end = ray.start.xy + ray.step.xy * hit.u;
    let seen = rim_fade(end, vec2<f32>(reflections.viewport_size), reflections.edge_fade);
    let confidence = hit.certainty * seen * fade * select(0.0, 1.0, is_in_last_view(at));
    let is_number = is_finite(light.r + light.g + light.b + confidence);
    return select(vec4(0.0), vec4(light, confidence), is_number && confidence > 0.0);
}
#else   // FORWARD_REFLECTIONS
fn lean_reflected_light(position: vec3<f32>, normal: vec3<f32>, roughness: f32) -> vec4<f32> {
    return vec4(0.0);
}
#endif  // FORWARD_REFLECTIONS
