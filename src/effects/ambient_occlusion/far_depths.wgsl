// Copies the depth of every fourth pixel of every fourth row, for samples far from their pixel: those of neighbouring pixels then
// share cache lines.
#import bevy_lean_deferred::effects::ambient_occlusion::bindings::{depth_at, far_depths_output}
#import bevy_lean_deferred::rounding::CELL_SIDE
#import bevy_lean_deferred::tiles::pixel_in_view

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let cell = pixel_in_view(tile.xy, invocation);
    if all(cell < textureDimensions(far_depths_output)) {
        textureStore(far_depths_output, cell, vec4(depth_at(CELL_SIDE * vec2<i32>(cell)), 0.0, 0.0, 0.0));
    }
}
