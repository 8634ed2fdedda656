// Adds the change by scattering to the picture, in the listed blocks.
#import bevy_lean_deferred::gbuffer::layout::light::within_halves
#import bevy_lean_deferred::lighting::subsurface_light::{tile_bit, unpack_entry, unpack_material, unpack_receiver}
#import bevy_lean_deferred::effects::subsurface::{
    bindings::{light_texture, output_texture, picture_texture, scattered_texture, view},
    entries::{Square, keep, read_materials, texel_of},
    scattered::{added_at, normal_of, surface_with},
    texel::{count_of_blocks, is_listed, listed_block, mask_of, to_viewer},
}

/// Side in pixels of the quarter of a block that a workgroup processes at once.
const MADE: i32 = 16;

/// Scattered light of a texel of the first level.
fn coarser_at(texel: vec2<i32>) -> vec2<u32> {
    return select(vec2(0u), textureLoad(scattered_texture, max(texel, vec2(0)), 0).rg, is_listed(texel >> vec2(4u)));
}

/// Words that lighting wrote for a pixel.
struct Written {
    entering: vec2<u32>,
    receiver: vec4<u32>,
}

fn show(pixel: vec2<i32>, written: Written, coarser: Square) {
    let entry = unpack_entry(written.entering);
    let receiver = unpack_receiver(written.receiver);
    let toward = to_viewer(vec2<f32>(pixel) + 0.5);
    let surface = surface_with(normal_of(receiver.normal_word, toward), toward, entry, 0u);
    let added = added_at(pixel, surface, coarser);
    // The pixel is kept if nothing, or NaN, is added.
    if any(added != vec3(0.0)) && all(abs(added) < vec3(1e30)) {
        let color = within_halves(receiver.color.rgb + receiver.leaving * added);
        textureStore(output_texture, vec2<i32>(view.viewport_origin) + pixel, vec4(color, receiver.color.a));
    }
}

@compute @workgroup_size(256, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    let invocation = i32(index);
    read_materials(index);
    let count = 4u * count_of_blocks();
    for (var i = workgroup.x; i < count; i += workgroups.x) {
        let block = listed_block(i >> 2u);
        let corner = block * 32 + vec2<i32>(vec2(i & 1u, (i >> 1u) & 1u)) * MADE;
        let coarser = Square(0, 10, corner / 2 - 1);
        let pixel = corner + vec2(invocation % MADE, invocation / MADE);
        let written = Written(textureLoad(light_texture, pixel, 0).rg, textureLoad(picture_texture, pixel, 0));
        let coarser_words = coarser_at(texel_of(coarser, invocation));
        let is_written = (mask_of(block) & tile_bit(vec2<u32>(pixel))) != 0u;
        // Waits until the previous entries are read.
        workgroupBarrier();
        keep(coarser, invocation, coarser_words);
        workgroupBarrier();
        if is_written && unpack_material(written.entering.x) != 0u {
            show(pixel, written, coarser);
        }
    }
}
