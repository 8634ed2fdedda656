// Draws a `StandardMaterial` with a `ShadingExtension` into the packed G-buffer.
#import bevy_lean_deferred::gbuffer::pack::{GBufferOutput, apply_discards, pack_pbr_input}
#import bevy_pbr::{
    pbr_fragment::pbr_input_from_standard_material,
    prepass_io::VertexOutput,
}

#ifdef GBUFFER_SPECIALIZATION
#import bevy_lean_deferred::gbuffer::{layout::specialization::PLAIN, pack::pack_shading_model}
#import bevy_lean_deferred::material_extension::extension::extension_of
#endif

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> GBufferOutput {
    var pbr_input = pbr_input_from_standard_material(in, is_front);
    apply_discards(in, &pbr_input);
#ifdef GBUFFER_SPECIALIZATION
    let extension = extension_of(in.instance_index);
    if extension.shading_model != PLAIN {
        return pack_shading_model(pbr_input, in, extension.shading_model, extension.arguments);
    }
#endif
    return pack_pbr_input(pbr_input, in);
}
