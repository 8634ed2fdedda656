//! Fragment shaders of materials that extend `StandardMaterial`, for the forward pass and for the G-buffer.

use bevy::prelude::*;
use kit::headless::Headless;

/// The forward shader, with `change` made to `pbr` before lighting.
pub fn forward_main(change: &str) -> String {
    format!(
        r"
#import bevy_pbr::{{
    forward_io::{{FragmentOutput, VertexOutput}},
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{{alpha_discard, apply_pbr_lighting, main_pass_post_lighting_processing}},
}}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {{
    var pbr = pbr_input_from_standard_material(in, is_front);
    {change}
    pbr.material.base_color = alpha_discard(pbr.material, pbr.material.base_color);
    return FragmentOutput(main_pass_post_lighting_processing(pbr, apply_pbr_lighting(pbr)));
}}
"
    )
}

/// The G-buffer shader, with `change` made to `pbr` before packing.
pub fn gbuffer_main(change: &str) -> String {
    format!(
        r"
#import bevy_lean_deferred::gbuffer::pack::{{GBufferOutput, apply_discards, pack_pbr_input}}
#import bevy_pbr::{{
    pbr_fragment::pbr_input_from_standard_material,
    prepass_io::VertexOutput,
}}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> GBufferOutput {{
    var pbr = pbr_input_from_standard_material(in, is_front);
    {change}
    apply_discards(in, &pbr);
    return pack_pbr_input(pbr, in);
}}
"
    )
}

pub fn insert_shader(headless: &mut Headless, handle: Handle<Shader>, source: String, file: &str) {
    let mut shaders = headless.world().resource_mut::<Assets<Shader>>();
    let shader = Shader::from_wgsl(source, file);
    shaders
        .insert(handle.id(), shader)
        .expect("a place for a constant handle");
}
