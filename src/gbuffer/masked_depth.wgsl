// Draws the depth of an alpha-masked `StandardMaterial`: discards what `gbuffer.wgsl` discards.
#import bevy_lean_deferred::gbuffer::pack::apply_discards
#import bevy_pbr::{
    pbr_fragment::pbr_input_from_standard_material,
    prepass_io::VertexOutput,
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) {
    var pbr_input = pbr_input_from_standard_material(in, is_front);
    apply_discards(in, &pbr_input);
}
