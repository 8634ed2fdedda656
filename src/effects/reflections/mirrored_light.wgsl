// Light of a surface in a mirror.
#define_import_path bevy_lean_deferred::effects::reflections::mirrored_light

#import bevy_lean_deferred::distance_fog::{CLEAR, fogged_in_mirror, without_fog}
#import bevy_lean_deferred::effects::reflections::bindings::view
#import bevy_lean_deferred::effects::reflections::surface::last_light

/// As `last_light`, in a mirror that is `to_mirror` metres away from the viewer, and `metres` from the surface: with the fog between
/// these two in place of the fog between surface and viewer. Lighting adds the fog in front of the mirror.
fn mirrored_light(
    place: vec3<f32>,
    position: vec3<f32>,
    level: f32,
    blurs_edges: bool,
    to_mirror: f32,
    metres: f32,
) -> vec4<f32> {
    let seen = last_light(place, position, level, blurs_edges);
    if view.fog.mode == CLEAR {
        return seen;
    }
    let light = without_fog(view.fog, seen.rgb, length(position), view.exposure_ratio);
    return vec4(fogged_in_mirror(view.fog, light, to_mirror, to_mirror + metres), seen.w);
}
