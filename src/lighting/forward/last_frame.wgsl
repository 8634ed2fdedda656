// A ray in the last frame: its distance from the surface there, and the light of that surface.
#define_import_path bevy_lean_deferred::lighting::forward::last_frame

#ifdef FORWARD_REFLECTIONS
#import bevy_lean_deferred::gathered::{interpolated, largest_difference, nearest_of}
#import bevy_lean_deferred::lighting::forward::bindings::{history_sampler, history_texture, reflections}

/// Above all distances, for pixels without a surface.
const NOTHING: f32 = 1e30;
/// As the history stores the distance of the sky.
const NO_SURFACE: f32 = 65504.0;

/// A ray in the last frame. Both are linear in the metres along it.
struct LastRay {
    /// Homogeneous pixel.
    pixel: vec3<f32>,
    pixel_step: vec3<f32>,
    /// Distance along the view direction, in metres.
    distance: f32,
    distance_step: f32,
}

/// The ray from `position` in unit `direction`, both in view space.
fn last_ray(position: vec3<f32>, direction: vec3<f32>) -> LastRay {
    let start = vec4(position, 1.0);
    let along = vec4(direction, 0.0);
    let m = reflections.last_pixel_from_view;
    return LastRay(
        (m * start).xyw, (m * along).xyw,
        dot(reflections.last_distance, start), dot(reflections.last_distance, along),
    );
}

/// Pixel after `metres`. Negative behind the camera.
fn last_pixel(ray: LastRay, metres: f32) -> vec2<f32> {
    let seen = ray.pixel + ray.pixel_step * metres;
    return select(vec2(-1.0), seen.xy / seen.z, seen.z > 0.0);
}

fn last_distance(ray: LastRay, metres: f32) -> f32 {
    return ray.distance + ray.distance_step * metres;
}

fn is_in_last_view(at: vec2<f32>) -> bool {
    return all(at >= vec2(0.0)) && all(at < reflections.last_viewport_size);
}

/// Distance of the surface at a pixel, in metres.
fn kept_distance(at: vec2<f32>) -> f32 {
    let kept = textureLoad(history_texture, vec2<i32>(at), 0).a;
    return select(NOTHING, kept * reflections.metres_per_unit, is_in_last_view(at) && abs(kept) < NO_SURFACE);
}

/// Metres that separate surfaces one pixel apart, `distance` metres away.
fn edge_step(distance: f32) -> f32 {
    return reflections.edge_metres * select(abs(distance), 1.0, reflections.is_orthographic == 1u);
}

/// A surface between the centres of pixels.
struct KeptSurface {
    distance: f32,
    /// Position at which its light is sampled: moved to a pixel's centre where another surface is beside it.
    place: vec2<f32>,
}

fn kept_surface(at: vec2<f32>) -> KeptSurface {
    let first = floor(at - 0.5);
    let along = at - 0.5 - first;
    // At their common corner: near a texel's centre, rounding may select others.
    let corner = (first + 1.0) / reflections.history_size;
    let around = textureGather(3, history_texture, history_sampler, corner) * reflections.metres_per_unit;
    let nearest = nearest_of(around, along);
    // Half floats have eleven significant bits.
    if largest_difference(around, nearest) > edge_step(nearest) + 0.001 * abs(nearest) {
        return KeptSurface(nearest, first + select(vec2(0.5), vec2(1.5), along >= vec2(0.5)));
    }
    return KeptSurface(interpolated(around, along), at);
}

/// Mean light around a pixel of the last frame, exposed as this one, over 2 to the power of `level` pixels.
fn kept_light(at: vec2<f32>, level: f32) -> vec3<f32> {
    let place = at / reflections.history_size;
    // From level 1 on, alpha is the share of surfaces.
    let coarse = textureSampleLevel(history_texture, history_sampler, place, max(level, 1.0));
    let mean = coarse.rgb / max(coarse.a, 1e-3);
    let fine = textureSampleLevel(history_texture, history_sampler, place, 0.0).rgb;
    return mix(fine, mean, saturate(level)) * reflections.exposure_ratio;
}
#endif  // FORWARD_REFLECTIONS
