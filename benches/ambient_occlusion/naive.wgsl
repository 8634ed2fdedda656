// The technique that the crate replaces: occlusion in the alpha of four half-precision channels, nine fetches to blur
// it, and a merge in the shader.
#import bevy_lean_deferred::effects::ambient_occlusion::bindings::{depth_at, depth_texture, view}
#import bevy_lean_deferred::effects::ambient_occlusion::hbao::hbao
#import bevy_lean_deferred::reconstruction::normal_from_depth::{DepthView, depths_around}

#ifdef GATHER
@group(0) @binding(4) var output_texture: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn gather(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.viewport_size) {
        return;
    }
    let depth = depth_at(vec2<i32>(id.xy));
    var occlusion = 0.0;
    if depth > 0.0 {
        let pixel = vec2<i32>(id.xy);
        let in_depth = DepthView(vec2<i32>(view.viewport_origin), vec2<i32>(view.viewport_size));
        let around = depths_around(depth_texture, in_depth, pixel, false);
        occlusion = hbao((id.x & 1u) | ((id.y & 1u) << 1u), id.xy, pixel, pixel & vec2(1), depth, around);
    }
    textureStore(output_texture, id.xy, vec4(1.0, 1.0, 1.0, 1.0 - occlusion));
}
#else
@group(0) @binding(4) var occlusion_texture: texture_2d<f32>;
@group(0) @binding(5) var picture: texture_2d<f32>;

@fragment
fn merge(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(position.xy);
    var visibility = 0.0;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let sample = clamp(pixel + vec2(x, y), vec2(0), vec2<i32>(view.viewport_size) - 1);
            visibility += textureLoad(occlusion_texture, sample, 0).a / 9.0;
        }
    }
#ifdef SHOWS
    return vec4(vec3(visibility), 1.0);
#else
    let color = textureLoad(picture, pixel, 0);
    return vec4(color.rgb * visibility, color.a);
#endif
}
#endif
