// The tiles that scattering goes over, and the materials in one.
#define_import_path bevy_lean_deferred::screen_space::subsurface::tile

#import bevy_lean_deferred::lighting::tile_list::{corner_of, index_in_list}
#import bevy_lean_deferred::screen_space::subsurface::bindings::tiles

struct Tile {
    /// False for workgroups beyond the end of the list.
    is_listed: bool,
    /// Its first pixel, from the corner of the viewport.
    origin: vec2<u32>,
}

fn tile_of(workgroup: vec2<u32>) -> Tile {
    let count = tiles[0];
    let index = index_in_list(workgroup);
    return Tile(index < count, corner_of(tiles[1u + min(index, max(count, 1u) - 1u)]));
}

/// No arguments of any material.
const NO_MATERIAL: u32 = 0xffffffffu;

var<workgroup> least: atomic<u32>;
var<workgroup> chosen: u32;

/// The same for all invocations: the arguments of a material that some of them have, the least; `NO_MATERIAL` if none has any.
fn next_material(arguments: u32, invocation: u32) -> u32 {
    if invocation == 0u {
        atomicStore(&least, NO_MATERIAL);
    }
    workgroupBarrier();
    if arguments != NO_MATERIAL {
        atomicMin(&least, arguments);
    }
    workgroupBarrier();
    if invocation == 0u {
        chosen = atomicLoad(&least);
    }
    return workgroupUniformLoad(&chosen);
}
