// Writes motion vectors of pixels with lean meshes: from the motion target or, for surfaces at rest, from depth and the
// cameras of this frame and the last.
#import bevy_lean_deferred::gbuffer::layout
#import bevy_lean_deferred::gbuffer::layout::motion::unpack_motion
#import bevy_lean_deferred::reconstruction::{
    motion::motion_at_rest,
    position::{homogeneous_position, ndc_of_fragment},
}
#import bevy_pbr::prepass_bindings::PreviousViewUniforms
#import bevy_render::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> previous_view: PreviousViewUniforms;
@group(0) @binding(2) var depth_texture: texture_depth_2d;
#ifdef LATE
/// Depth before the second phase of culling.
@group(0) @binding(3) var earlier_depth_texture: texture_depth_2d;
#else
@group(0) @binding(3) var normal_texture: texture_2d<u32>;
#endif
#ifdef GBUFFER_MOTION
@group(0) @binding(4) var motion_texture: texture_2d<u32>;
@group(0) @binding(5) var valid_mask_texture: texture_2d<u32>;
#endif

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
    if (textureLoad(valid_mask_texture, pixel, 0).r & layout::MOTION_VALID) != 0u {
        return unpack_motion(textureLoad(motion_texture, pixel, 0).r);
    }
#endif
    let ndc = vec3(ndc_of_fragment(position.xy, view.main_pass_viewport), depth);
    return motion_at_rest(
        homogeneous_position(view.view_from_clip, ndc),
        view.world_from_view,
        view.unjittered_clip_from_world,
        previous_view.clip_from_world,
    );
}
