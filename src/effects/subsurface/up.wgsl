// Scatters a level from the scattered light two levels coarser. The level between is scattered here too, around the texels of each
// workgroup. Either a whole level, or the listed blocks (LISTED).
#import bevy_lean_deferred::effects::subsurface::{
    bindings::{coarser_texture, light_texture, scattered_output, scattered_texture, view},
    entries::{Square, count_of, keep, read_materials, texel_of},
    scattered::{scattered, shown_at},
}
#ifdef LISTED
#import bevy_lean_deferred::effects::subsurface::texel::{count_of_blocks, is_listed, listed_block}
#else
#import bevy_lean_deferred::workgroup::is_any
#endif

/// Side of a workgroup's output in texels, one per invocation. A listed block has this side in the first level, and a whole level a
/// multiple of it: the textures are as large as the texels of the coarsest level need.
const MADE: u32 = 16u;

/// Scattered light two levels coarser.
fn coarsest_at(texel: vec2<i32>) -> vec2<u32> {
    let inside = clamp(texel, vec2(0), vec2<i32>(textureDimensions(scattered_texture)) - 1);
    return select(vec2(0u), textureLoad(scattered_texture, inside, 0).rg, all(inside == texel));
}

/// Light that enters surfaces, one level coarser.
fn coarser_at(texel: vec2<i32>) -> vec2<u32> {
    let inside = clamp(texel, vec2(0), vec2<i32>(textureDimensions(coarser_texture)) - 1);
    var is_known = all(inside == texel);
#ifdef LISTED
    is_known &= is_listed(texel >> vec2(3u));
#endif
    return select(vec2(0u), textureLoad(coarser_texture, inside, 0).rg, is_known);
}

/// Makes the texels from `corner` on.
fn make(corner: vec2<i32>, index: u32) {
    let invocation = i32(index);
    // Two texels around those beneath: as far as kernels are stretched.
    let coarser = Square(0, 12, corner / 2 - 2);
    let coarsest = Square(count_of(coarser), 10, coarser.corner / 2 - 2);
    let texel = corner + vec2<i32>(vec2(index % MADE, index / MADE));
    let words = textureLoad(light_texture, texel, 0).rg;
#ifndef LISTED
    if !is_any(words.x != 0u, index) {
        textureStore(scattered_output, texel, vec4(0u));
        return;
    }
#endif
    let beneath = texel_of(coarser, invocation);
    let coarser_words = coarser_at(beneath);
    let coarsest_words = coarsest_at(texel_of(coarsest, invocation));
    let shown = shown_at(texel, view.level);
    let shown_beneath = shown_at(beneath, view.level + 1u);
    // Waits until the previous entries are read.
    workgroupBarrier();
    keep(coarsest, invocation, coarsest_words);
    workgroupBarrier();
    if invocation < count_of(coarser) {
        let made = scattered(beneath, coarser_words, shown_beneath, view.level + 1u, coarsest);
        keep(coarser, invocation, made);
    }
    workgroupBarrier();
    textureStore(scattered_output, texel, vec4(scattered(texel, words, shown, view.level, coarser), 0u, 0u));
}

@compute @workgroup_size(256, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    read_materials(invocation);
#ifdef LISTED
    let count = count_of_blocks();
    for (var i = workgroup.x; i < count; i += workgroups.x) {
        make(listed_block(i) * i32(MADE), invocation);
    }
#else
    make(vec2<i32>(workgroup.xy) * i32(MADE), invocation);
#endif
}
