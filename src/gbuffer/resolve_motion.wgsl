// Writes the motion vectors of the pixels that lean meshes were drawn to: those in the motion target, and for all others
// those of a surface at rest, from depth and the cameras of this frame and the last.
#import bevy_lean_deferred::gbuffer::layout
#import bevy_lean_deferred::gbuffer::layout::motion
#import bevy_pbr::prepass_bindings::PreviousViewUniforms
#import bevy_render::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> previous_view: PreviousViewUniforms;
@group(0) @binding(2) var depth_texture: texture_depth_2d;
#ifdef LATE
/// Before the second phase of culling.
@group(0) @binding(3) var earlier_depth_texture: texture_depth_2d;
#else
@group(0) @binding(3) var normal_texture: texture_2d<u32>;
#endif
#ifdef GBUFFER_MOTION
@group(0) @binding(4) var motion_texture: texture_2d<u32>;
@group(0) @binding(5) var written_texture: texture_2d<u32>;
#endif

/// Through view space, not by `world_from_clip`: that matrix loses digits far from the origin. Never divided by w, so
/// that surfaces infinitely far away have a motion too.
fn motion_at_rest(frag_coord: vec2<f32>, depth: f32) -> vec2<f32> {
    let uv = (frag_coord - view.main_pass_viewport.xy) / view.main_pass_viewport.zw;
    let ndc = vec3(uv * vec2(2.0, -2.0) + vec2(-1.0, 1.0), depth);
    let world_position = view.world_from_view * (view.view_from_clip * vec4(ndc, 1.0));
    return motion::motion_between(
        view.unjittered_clip_from_world * world_position,
        previous_view.clip_from_world * world_position,
    );
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec2<f32> {
    let pixel = vec2<i32>(position.xy);
    let depth = textureLoad(depth_texture, pixel, 0);
#ifdef LATE
    let is_drawn = depth != textureLoad(earlier_depth_texture, pixel, 0);
#else
    let is_drawn = textureLoad(normal_texture, pixel, 0).r != layout::NO_GEOMETRY;
#endif
    if !is_drawn {
        discard;
    }
#ifdef GBUFFER_MOTION
    if (textureLoad(written_texture, pixel, 0).r & layout::MOTION_WRITTEN) != 0u {
        return motion::unpack_motion(textureLoad(motion_texture, pixel, 0).r);
    }
#endif
    return motion_at_rest(position.xy, depth);
}
