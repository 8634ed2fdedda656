// Adds the light of surfaces drawn by Bevy's forward passes: where they are nearest, their pixels of the picture are copied to
// the diffuse light that lighting wrote, which has no fog.
#import bevy_lean_deferred::distance_fog::{CLEAR, without_fog}
#import bevy_lean_deferred::gbuffer::layout::NO_GEOMETRY
#import bevy_lean_deferred::gbuffer::layout::light::pack_light
#import bevy_lean_deferred::reconstruction::position::view_position
#import bevy_lean_deferred::effects::diffuse_gi::bindings::{
    depth_texture, diffuse_light_output, normal_texture, picture_texture, view,
}

@compute @workgroup_size(8, 8, 1)
fn main(@builtin(global_invocation_id) pixel: vec3<u32>) {
    if any(pixel.xy >= view.viewport_size) {
        return;
    }
    let place = vec2<i32>(view.viewport_origin + pixel.xy);
    let is_lean = textureLoad(normal_texture, place, 0).r != NO_GEOMETRY;
    let depth = textureLoad(depth_texture, place, 0);
    if is_lean || !(depth > 0.0) {
        return;
    }
    var light = textureLoad(picture_texture, place, 0).rgb;
    if view.fog.mode != CLEAR {
        let position = view_position(view.view_from_pixel, vec3(vec2<f32>(pixel.xy) + 0.5, depth));
        light = without_fog(view.fog, light, length(position), 1.0);
    }
    textureStore(diffuse_light_output, pixel.xy, vec4(pack_light(light)));
}
