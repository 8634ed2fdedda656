// assets/shaders/rings.wgsl: one shader for Bevy's forward pass and for the G-buffer.
#import bevy_pbr::pbr_fragment::pbr_input_from_vertex_output

#ifdef PREPASS_PIPELINE
#import bevy_lean_deferred::gbuffer::pack::{GBufferOutput, pack_pbr_input}
#import bevy_pbr::prepass_io::VertexOutput
#else
#import bevy_pbr::{
    forward_io::{FragmentOutput, VertexOutput},
    pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing},
}
#endif

// Colour, and rings per metre.
@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> rings: vec4<f32>;

#ifdef PREPASS_PIPELINE
@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> GBufferOutput {
#else
@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
#endif
    // The surface, for both passes.
    var pbr_input = pbr_input_from_vertex_output(in, is_front, false);
    pbr_input.N = normalize(pbr_input.world_normal);
    let is_dark = fract(in.world_position.y * rings.w) < 0.5;
    pbr_input.material.base_color = vec4(rings.rgb * select(1.0, 0.2, is_dark), 1.0);
    pbr_input.material.perceptual_roughness = 0.4;

    // Pack it, to be lit later; or light it here.
#ifdef PREPASS_PIPELINE
    return pack_pbr_input(pbr_input, in);
#else
    let color = apply_pbr_lighting(pbr_input);
    return FragmentOutput(main_pass_post_lighting_processing(pbr_input, color));
#endif
}
