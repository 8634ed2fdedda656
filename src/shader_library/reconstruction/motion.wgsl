// Motion of surfaces at rest, from depth. Without bindings: matrices are passed in by value.
#define_import_path bevy_lean_deferred::reconstruction::motion

#import bevy_lean_deferred::gbuffer::layout::motion::motion_between

/// Motion across the picture, in UV units, of a point at rest at `position`, which is homogeneous in view space: only the camera
/// moves. Never divided by w, so that points infinitely far away have motion too.
fn motion_at_rest(
    position: vec4<f32>,
    world_from_view: mat4x4<f32>,
    clip_from_world: mat4x4<f32>,
    previous_clip_from_world: mat4x4<f32>,
) -> vec2<f32> {
    let world_position = world_from_view * position;
    return motion_between(clip_from_world * world_position, previous_clip_from_world * world_position);
}
