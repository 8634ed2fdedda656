// Adds the light of surfaces drawn by Bevy's forward passes: where they are nearest, their pixels of the picture are copied to
// the diffuse light that lighting wrote.
#import bevy_lean_deferred::gbuffer::layout::NO_GEOMETRY
#import bevy_lean_deferred::gbuffer::layout::light::pack_light
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
    if is_lean || !(textureLoad(depth_texture, place, 0) > 0.0) {
        return;
    }
    let light = textureLoad(picture_texture, place, 0).rgb;
    textureStore(diffuse_light_output, pixel.xy, vec4(pack_light(light)));
}
