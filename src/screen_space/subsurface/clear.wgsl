// Leaves the light of the tiles as it was before this frame: none. So the rest of its textures is never touched.
#import bevy_lean_deferred::screen_space::subsurface::bindings::{level_0, level_1, level_2, level_3}
#import bevy_lean_deferred::screen_space::subsurface::tile::tile_of

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let tile = tile_of(workgroup.xy);
    if !tile.is_listed {
        return;
    }
    textureStore(level_0, tile.origin + vec2(invocation & 7u, invocation >> 3u), vec4(0u));
    if invocation < 16u {
        textureStore(level_1, tile.origin / 2u + vec2(invocation & 3u, invocation >> 2u), vec4(0u));
    }
    if invocation < 4u {
        textureStore(level_2, tile.origin / 4u + vec2(invocation & 1u, invocation >> 1u), vec4(0u));
    }
    if invocation == 0u {
        textureStore(level_3, tile.origin / 8u, vec4(0u));
    }
}
