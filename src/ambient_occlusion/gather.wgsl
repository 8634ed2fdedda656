// Finds the occlusion of each texel: as a compute pass, or as a fragment pass where the format cannot be stored to.
#import bevy_lean_deferred::ambient_occlusion::bindings::{depth_at, view}
#import bevy_lean_deferred::gbuffer::layout::is_finite

#ifdef HDAO
#import bevy_lean_deferred::ambient_occlusion::hdao::hdao
#else
#import bevy_lean_deferred::ambient_occlusion::hbao::hbao
#endif

/// Where the pixels of each phase lie in the 2×2 pattern: neighbours along an axis look in rather different directions.
fn place_of(phase: u32) -> vec2<u32> {
    return vec2(phase & 1u, u32(phase == 1u || phase == 2u));
}

fn phase_at(texel: vec2<u32>) -> u32 {
    let x = texel.x & 1u;
    return select(2u - x, 3u * x, (texel.y & 1u) == 0u);
}

fn occlusion_at(texel: vec2<u32>, phase: u32) -> f32 {
    let pixel = vec2<i32>(texel * #{DIVISOR}u);
    let depth = depth_at(pixel);
    // Sky, and what is not a number.
    if !(depth > 0.0) {
        return 0.0;
    }
#ifdef HDAO
    let occlusion = hdao(pixel, depth);
#else
    let occlusion = hbao(phase, pixel, depth);
#endif
    return select(0.0, saturate(occlusion), is_finite(occlusion));
}

#ifdef COMPUTE
#import bevy_lean_deferred::ambient_occlusion::bindings::output_texture
#import bevy_lean_deferred::tiles::pixel_in_view

/// 64 invocations find 16×16 texels, one phase after the other: so all of a subgroup look in one direction at a time.
@compute @workgroup_size(64, 1, 1)
fn compute(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(num_workgroups) tiles: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let block = 2u * pixel_in_view(tile.xy, tiles.xy, view.row_stride, invocation);
    for (var phase = 0u; phase < 4u; phase++) {
        let texel = block + place_of(phase);
        if all(texel < view.texture_size) {
            textureStore(output_texture, texel, vec4(occlusion_at(texel, phase), 0.0, 0.0, 0.0));
        }
    }
}
#else
@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let texel = vec2<u32>(position.xy);
    let occlusion = occlusion_at(texel, phase_at(texel));
    // The target was cleared to none.
    if occlusion == 0.0 {
        discard;
    }
    return vec4(occlusion, 0.0, 0.0, 0.0);
}
#endif
