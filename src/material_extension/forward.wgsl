// Draws a `StandardMaterial` with a `ShadingExtension` in Bevy's forward passes.
#define SHADING_MODEL_RIM
#import bevy_lean_deferred::gbuffer::layout::specialization::RIM
#import bevy_lean_deferred::material_extension::extension::extension_of
#import bevy_lean_deferred::shading_models::rim::{light_behind, rim_light}
#import bevy_pbr::{
    decal::clustered::apply_decals,
    forward_io::{FragmentOutput, VertexOutput},
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{alpha_discard, apply_pbr_lighting, main_pass_post_lighting_processing},
    pbr_types::{
        PbrInput, STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE,
        STANDARD_MATERIAL_FLAGS_ALPHA_MODE_RESERVED_BITS, STANDARD_MATERIAL_FLAGS_UNLIT_BIT,
    },
}

#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither
#endif

#ifdef OIT_ENABLED
#import bevy_core_pipeline::oit::oit_draw
#endif

fn light(pbr: PbrInput, instance_index: u32) -> vec4<f32> {
    if (pbr.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) != 0u {
        return pbr.material.base_color;
    }
    var color = apply_pbr_lighting(pbr);
    let extension = extension_of(instance_index);
    if extension.shading_model == RIM {
#ifdef LIGHTMAP
        let is_lightmapped = true;
#else
        let is_lightmapped = false;
#endif
        color = vec4(color.rgb + rim_light(pbr, extension.arguments, light_behind(pbr, is_lightmapped)), color.a);
    }
    return color;
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
#ifdef VISIBILITY_RANGE_DITHER
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif
    var pbr = pbr_input_from_standard_material(in, is_front);
    pbr.material.base_color = alpha_discard(pbr.material, pbr.material.base_color);
    apply_decals(&pbr);
    var out: FragmentOutput;
    out.color = main_pass_post_lighting_processing(pbr, light(pbr, in.instance_index));
#ifdef OIT_ENABLED
    // As in Bevy's `pbr.wgsl`: stored for the pass that sorts transparent fragments.
    let alpha_mode = pbr.material.flags & STANDARD_MATERIAL_FLAGS_ALPHA_MODE_RESERVED_BITS;
    if alpha_mode != STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE {
        oit_draw(in.position, out.color);
        discard;
    }
#endif
    return out;
}
