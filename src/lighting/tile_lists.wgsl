// Lists of the tiles that have pixels of each special kind. Twin of `variants.rs` and `tile_lists.rs`.
#define_import_path bevy_lean_deferred::lighting::tile_lists

#import bevy_lean_deferred::gbuffer::layout::specialization
#import bevy_lean_deferred::lighting::bindings::uniforms

/// Variants that can be told apart; each has a counter, and its list follows in the order of their numbers.
const VARIANTS: u32 = 16u;
/// Workgroups a row of an indirect dispatch: the lists may be longer than a dispatch may be wide.
const COLUMNS: u32 = 32768u;

/// The variant of the lighting pass that lights a pixel: 0 for plain surfaces.
fn variant_of(word: u32) -> u32 {
    var model = specialization::unpack_shading_model(word);
    if model == specialization::UNLIT {
        return 0u;
    }
    model = select(model, specialization::PLAIN, model == specialization::SUBSURFACE);
    let lightmapped = (word & specialization::LIGHTMAP_BITS) != specialization::LIGHTMAP_NONE;
    return model | select(0u, 8u, lightmapped);
}

#ifdef LISTED_VARIANTS
/// `x`, `y`, `z` of an indirect dispatch for each variant; `z` is always 1.
@group(3) @binding(0) var<storage, read_write> dispatches: array<atomic<u32>>;
@group(3) @binding(1) var<storage, read_write> lists: array<atomic<u32>>;

var<workgroup> present: atomic<u32>;

/// Puts the tile whose corner is `origin` on the list of each variant that one of its 64 invocations has.
fn list_tile(origin: vec2<u32>, variant: u32, invocation: u32) {
    // Whatever ran before has left something there.
    if invocation == 0u {
        atomicStore(&present, 0u);
    }
    workgroupBarrier();
    if variant != 0u {
        atomicOr(&present, 1u << variant);
    }
    workgroupBarrier();
    if invocation != 0u {
        return;
    }
    var left = atomicLoad(&present) & #{LISTED_VARIANTS}u;
    while left != 0u {
        let listed = firstTrailingBit(left);
        left &= left - 1u;
        let list = VARIANTS + uniforms.list_capacity * rank_of(listed);
        let index = atomicAdd(&lists[listed], 1u);
        atomicStore(&lists[list + index], origin.x | (origin.y << 16u));
        atomicMax(&dispatches[3u * listed], min(index + 1u, COLUMNS));
        atomicMax(&dispatches[3u * listed + 1u], index / COLUMNS + 1u);
    }
}

/// How many listed variants have smaller numbers.
fn rank_of(variant: u32) -> u32 {
    return countOneBits(#{LISTED_VARIANTS}u & ((1u << variant) - 1u));
}
#endif

#ifdef LIGHTING_VARIANT
@group(3) @binding(1) var<storage, read> lists: array<u32>;

struct ListedTile {
    /// False for workgroups beyond the end of the list.
    is_listed: bool,
    origin: vec2<u32>,
}

fn listed_tile(workgroup: vec2<u32>) -> ListedTile {
    let index = workgroup.y * COLUMNS + workgroup.x;
    let list = VARIANTS + uniforms.list_capacity * #{LIST_RANK}u;
    let place = lists[list + min(index, uniforms.list_capacity - 1u)];
    return ListedTile(index < lists[#{LIGHTING_VARIANT}], vec2(place & 0xffffu, place >> 16u));
}
#endif
