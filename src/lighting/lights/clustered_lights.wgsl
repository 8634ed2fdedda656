// Light from the point and spot lights of a pixel's cluster, in Bevy's order.
//
// Without LIGHT_CULLING, each pixel visits all of them; one that does not reach it costs a dozen instructions. With it, the
// invocations of a tile cull lights together, one light per invocation, and all visit the rest. Each batch of lights is a bit
// mask over the invocations, so no list of variable length is stored.
#define_import_path bevy_lean_deferred::lighting::lights::clustered_lights

#import bevy_lean_deferred::lighting::lights::clustered_light::add_clustered_light
#import bevy_lean_deferred::lighting::lights::brdf::LightAccumulator
#import bevy_lean_deferred::lighting::lights::shading_point::{NO_CLUSTER, ShadingPoint}
#import bevy_pbr::clustered_forward::{
    get_clusterable_object_id, unpack_clusterable_object_index_ranges,
}

#ifdef LIGHT_CULLING
#import bevy_lean_deferred::lighting::lights::reach::{box_of_tile, may_reach}
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#import bevy_lean_deferred::lighting::lights::shading_point::transmits

/// Distance in metres behind the surface at which it also gathers light.
fn reach_of(point: ptr<function, ShadingPoint>) -> f32 {
    return select(0.0, (*point).thickness, transmits(point));
}
#endif
#endif

#ifndef LIGHT_CULLING
fn add_clustered_lights(
    point: ptr<function, ShadingPoint>,
    corner: vec2<u32>,
    cluster: u32,
    member: u32,
    accumulator: ptr<function, LightAccumulator>,
) {
    if cluster == NO_CLUSTER {
        return;
    }
    let ranges = unpack_clusterable_object_index_ranges(cluster);
    let end = ranges.first_reflection_probe_index_offset;
    for (var i = ranges.first_point_light_index_offset; i < end; i++) {
        add_clustered_light(point, get_clusterable_object_id(i), accumulator);
    }
}
#else ifdef LIGHT_CULLING_BY_SUBGROUPS
/// Number of ones below bit `lane` of a ballot.
fn ones_below(ballot: vec2<u32>, lane: u32) -> u32 {
    let low = countOneBits(ballot.x & select((1u << (lane & 31u)) - 1u, 0xffffffffu, lane >= 32u));
    let high = countOneBits(ballot.y & ((1u << (lane & 31u)) - 1u));
    return low + select(0u, high, lane >= 32u);
}

/// Must be called by all invocations of the workgroup, also where `cluster` is `NO_CLUSTER`. `corner` is the tile's first pixel.
///
/// Results stay correct where a subgroup has diverged: each part visits all lights by itself.
fn add_clustered_lights(
    point: ptr<function, ShadingPoint>,
    corner: vec2<u32>,
    cluster: u32,
    lane: u32,
    accumulator: ptr<function, LightAccumulator>,
) {
    var left = cluster;
    loop {
        let current = subgroupMin(left);
        if current == NO_CLUSTER {
            break;
        }
        let is_here = left == current;
        left = select(left, NO_CLUSTER, is_here);
        let ranges = unpack_clusterable_object_index_ranges(current);
        let end = ranges.first_reflection_probe_index_offset;
        var first = ranges.first_point_light_index_offset;
        if first == end {
            continue;
        }
        let least = subgroupMin(select(1e30, (*point).depth, is_here));
        let most = subgroupMax(select(-1e30, (*point).depth, is_here));
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
        let reach = subgroupMax(select(0.0, reach_of(point), is_here));
#else
        let reach = 0.0;
#endif
        let bounds = box_of_tile(corner, vec2(least, most), reach);
        while first < end {
            let present = subgroupBallot(true).xy;
            let index = first + ones_below(present, lane);
            var reaches = false;
            if index < end {
                reaches = may_reach(bounds, get_clusterable_object_id(index));
            }
            let ballot = subgroupBallot(reaches).xy;
            if is_here {
                for (var word = 0u; word < 2u; word++) {
                    var mask = select(ballot.x, ballot.y, word == 1u);
                    while mask != 0u {
                        let bit = 32u * word + firstTrailingBit(mask);
                        mask &= mask - 1u;
                        let id = get_clusterable_object_id(first + ones_below(present, bit));
                        add_clustered_light(point, id, accumulator);
                    }
                }
            }
            first += countOneBits(present.x) + countOneBits(present.y);
        }
    }
}
#else
/// Of the pixels still to be lit: lowest and highest cluster index, and smallest and largest depth, as bits.
var<workgroup> least_cluster: atomic<u32>;
var<workgroup> most_cluster: atomic<u32>;
var<workgroup> least_depth: atomic<u32>;
var<workgroup> most_depth: atomic<u32>;
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
/// Their largest `reach_of`, as bits.
var<workgroup> most_reach: atomic<u32>;
#endif
/// The first four above, read by one invocation for all: browsers require provably uniform control flow.
var<workgroup> found: vec4<u32>;
/// One bit per invocation, set if its light may reach the tile. Three buffers: one is cleared while another is filled and the
/// third may still be read.
var<workgroup> reaching: array<array<atomic<u32>, 2>, 3>;

/// Must be called by all 64 invocations of the workgroup, also where `cluster` is `NO_CLUSTER`. `corner` is the tile's first
/// pixel.
fn add_clustered_lights(
    point: ptr<function, ShadingPoint>,
    corner: vec2<u32>,
    cluster: u32,
    invocation: u32,
    accumulator: ptr<function, LightAccumulator>,
) {
    var left = cluster;
    loop {
        if invocation == 0u {
            atomicStore(&least_cluster, NO_CLUSTER);
            atomicStore(&most_cluster, 0u);
            atomicStore(&least_depth, 0xffffffffu);
            atomicStore(&most_depth, 0u);
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
            atomicStore(&most_reach, 0u);
#endif
            atomicStore(&reaching[0][0], 0u);
            atomicStore(&reaching[0][1], 0u);
        }
        workgroupBarrier();
        if left != NO_CLUSTER {
            atomicMin(&least_cluster, left);
            atomicMax(&most_cluster, left);
            // Depths are not negative, so their bits sort in the same order.
            let bits = bitcast<u32>((*point).depth);
            atomicMin(&least_depth, bits);
            atomicMax(&most_depth, bits);
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
            atomicMax(&most_reach, bitcast<u32>(reach_of(point)));
#endif
        }
        workgroupBarrier();
        if invocation == 0u {
            found = vec4(
                atomicLoad(&least_cluster),
                atomicLoad(&most_cluster),
                atomicLoad(&least_depth),
                atomicLoad(&most_depth),
            );
        }
        let all = workgroupUniformLoad(&found);
        let current = all.x;
        if current == NO_CLUSTER {
            break;
        }
        let is_last = current == all.y;
        let depths = all.zw;
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
        let reach = bitcast<f32>(atomicLoad(&most_reach));
#else
        let reach = 0.0;
#endif
        let bounds = box_of_tile(corner, bitcast<vec2<f32>>(depths), reach);
        let is_here = left == current;
        left = select(left, NO_CLUSTER, is_here);

        let ranges = unpack_clusterable_object_index_ranges(current);
        let end = ranges.first_reflection_probe_index_offset;
        var buffer = 0u;
        for (var first = ranges.first_point_light_index_offset; first < end; first += 64u) {
            let index = first + invocation;
            if index < end {
                if may_reach(bounds, get_clusterable_object_id(index)) {
                    atomicOr(&reaching[buffer][invocation >> 5u], 1u << (invocation & 31u));
                }
            }
            let next = select(buffer + 1u, 0u, buffer == 2u);
            if invocation < 2u {
                atomicStore(&reaching[next][invocation], 0u);
            }
            workgroupBarrier();
            for (var word = 0u; word < 2u; word++) {
                var mask = atomicLoad(&reaching[buffer][word]);
                mask = select(0u, mask, is_here);
                while mask != 0u {
                    let bit = 32u * word + firstTrailingBit(mask);
                    mask &= mask - 1u;
                    add_clustered_light(point, get_clusterable_object_id(first + bit), accumulator);
                }
            }
            buffer = next;
        }
        if is_last {
            break;
        }
        // All invocations have read the shared values before the next iteration resets them.
        workgroupBarrier();
    }
}
#endif
