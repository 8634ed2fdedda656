// Shows the light that filtered occlusion leaves in place of the picture: grey, white where nothing occludes or no surface is.
#import bevy_lean_deferred::effects::ambient_occlusion::bindings::{
    depth_texture, nearest_sampler, occlusion_texture, view,
}
#import bevy_lean_deferred::occlusion_filter::{OcclusionFilter, compiled_kind, filtered_occlusion}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(vec2<u32>(position.xy) - view.viewport_origin);
    let depth = textureLoad(depth_texture, vec2<i32>(position.xy), 0);
    var occlusion = 0.0;
    if depth > 0.0 {
        let parameters = OcclusionFilter(view.edge.xyz, view.intensity, view.viewport_origin, view.viewport_size);
        occlusion = filtered_occlusion(
            occlusion_texture, nearest_sampler, depth_texture, parameters, compiled_kind(), pixel, depth,
        );
    }
    return vec4(vec3(1.0 - occlusion), 1.0);
}
