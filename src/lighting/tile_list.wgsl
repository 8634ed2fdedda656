// List of tiles with special surfaces.
#define_import_path bevy_lean_deferred::lighting::tile_list

#import bevy_lean_deferred::gbuffer::layout::specialization

/// Workgroups per row of an indirect dispatch: the list may be longer than the limit of a dispatch's width.
const COLUMNS: u32 = 32768u;

/// Kind of surface that lighting has code for: its shading model, or 0 for those that are lit as plain ones.
fn variant_of(word: u32) -> u32 {
    let model = specialization::unpack_shading_model(word);
    let is_lit_as_plain = model == specialization::SUBSURFACE || model == specialization::UNLIT;
    return select(model, specialization::PLAIN, is_lit_as_plain);
}

#ifdef LISTED_VARIANTS
/// `x`, `y`, `z` of the indirect dispatch over the list; `z` is always 1.
@group(3) @binding(0) var<storage, read_write> dispatch: array<atomic<u32>, 3>;
/// Number of listed tiles, followed by their corners.
@group(3) @binding(1) var<storage, read_write> list: array<atomic<u32>>;

var<workgroup> has_special: atomic<u32>;
var<workgroup> is_listed: u32;

/// Lists the tile with corner `origin` if one of its 64 invocations has a special surface. Returns true for all of them if so.
fn list_tile(origin: vec2<u32>, variant: u32, invocation: u32) -> bool {
    // Workgroup memory may hold values of an earlier workgroup.
    if invocation == 0u {
        atomicStore(&has_special, 0u);
    }
    workgroupBarrier();
    if variant != 0u {
        atomicStore(&has_special, 1u);
    }
    workgroupBarrier();
    if invocation == 0u {
        is_listed = atomicLoad(&has_special);
        if is_listed != 0u {
            let index = atomicAdd(&list[0], 1u);
            atomicStore(&list[1u + index], origin.x | (origin.y << 16u));
            atomicMax(&dispatch[0], min(index + 1u, COLUMNS));
            atomicMax(&dispatch[1], index / COLUMNS + 1u);
        }
    }
    return workgroupUniformLoad(&is_listed) != 0u;
}
#endif

#ifdef VISITED_VARIANTS
@group(3) @binding(1) var<storage, read> list: array<u32>;

struct ListedTile {
    /// False for workgroups beyond the end of the list.
    is_listed: bool,
    origin: vec2<u32>,
}

fn listed_tile(workgroup: vec2<u32>) -> ListedTile {
    let count = list[0];
    let index = workgroup.y * COLUMNS + workgroup.x;
    let place = list[1u + min(index, max(count, 1u) - 1u)];
    return ListedTile(index < count, vec2(place & 0xffffu, place >> 16u));
}
#endif
