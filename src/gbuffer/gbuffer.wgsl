// Draws a `StandardMaterial` into the packed G-buffer.
#import bevy_lean_deferred::gbuffer::pack::{GBufferOutput, apply_discards, pack_pbr_input}
#import bevy_pbr::{
    pbr_fragment::pbr_input_from_standard_material,
    prepass_io::VertexOutput,
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> GBufferOutput {
    var pbr_input = pbr_input_from_standard_material(in, is_front);
    apply_discards(in, &pbr_input);
    return pack_pbr_input(pbr_input, in);
}
