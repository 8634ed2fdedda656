// How many workgroups go over the listed tiles, by how many of them each has: 1 or 4.
#import bevy_lean_deferred::lighting::subsurface_light::COUNT
#import bevy_lean_deferred::screen_space::subsurface::bindings::tiles_to_dispatch
#import bevy_lean_deferred::screen_space::subsurface::texel::COLUMNS

@compute @workgroup_size(2, 1, 1)
fn main(@builtin(local_invocation_index) level: u32) {
    let each = 1u << (2u * level);
    let count = (tiles_to_dispatch[COUNT] + each - 1u) / each;
    tiles_to_dispatch[3u * level] = min(count, COLUMNS);
    tiles_to_dispatch[3u * level + 1u] = (count + COLUMNS - 1u) / COLUMNS;
    tiles_to_dispatch[3u * level + 2u] = 1u;
}
