// Filters occlusion and applies it to the picture by the blend dst · (1 - occlusion).
#import bevy_lean_deferred::effects::ambient_occlusion::bindings::{
    depth_texture, nearest_sampler, occlusion_texture, view, view_position,
}
#import bevy_lean_deferred::occlusion_filter::{OcclusionFilter, compiled_kind, filtered_occlusion}

/// Share of a surface's light that distance fog transmits, as in Bevy's `fog.wgsl`.
fn fog_transmittance(pixel: vec2<i32>, depth: f32) -> f32 {
    let distance = length(view_position(pixel, depth));
    var extinction = 0.0;
    switch u32(view.fog.w) {
        case 1u: { extinction = 1.0 - saturate((view.fog.y - distance) / (view.fog.y - view.fog.x)); }
        case 2u: { extinction = 1.0 - exp(-distance * view.fog.x); }
        default: {
            let depth_of_fog = distance * view.fog.x;
            extinction = 1.0 - exp(-depth_of_fog * depth_of_fog);
        }
    }
    return 1.0 - extinction * view.fog.z;
}

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
        if view.fog.w != 0.0 {
            occlusion *= fog_transmittance(pixel, depth);
        }
    }
    if !(occlusion > 0.0) {
        discard;
    }
    return vec4(vec3(occlusion), 0.0);
}
