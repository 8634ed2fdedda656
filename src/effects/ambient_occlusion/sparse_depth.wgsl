// Stores the depths of the lattices.
#import bevy_lean_deferred::effects::ambient_occlusion::bindings::{depth_at, sparse_depth_output, view}
#import bevy_lean_deferred::effects::ambient_occlusion::lattice::{SPACING, corner_of_lattice, first_of_lattice}
#import bevy_lean_deferred::tiles::pixel_in_view

/// An invocation stores a pixel of each lattice, from 4×4 pixels.
@compute @workgroup_size(64, 1, 1)
fn compute(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let block = vec2<i32>(pixel_in_view(tile.xy, invocation));
    let size = vec2<i32>(view.viewport_size);
    if any(block * SPACING >= size) {
        return;
    }
    for (var i = 0; i < 4; i++) {
        let parity = vec2(i & 1, i >> 1u);
        let pixel = block * SPACING + first_of_lattice(parity);
        // Samples outside the view count for nothing.
        let depth = depth_at(min(pixel, size - 1));
        textureStore(sparse_depth_output, corner_of_lattice(parity, size) + block, vec4(depth));
    }
}
