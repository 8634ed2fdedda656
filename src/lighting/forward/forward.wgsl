// Lights a `StandardMaterial` mesh that Bevy's passes draw. Bevy's `pbr.wgsl`, with the crate's loop over lights in place of Bevy's.
// All bindings are Bevy's, but for the layers of lights.
#import bevy_lean_deferred::lighting::lights::{
    brdf::{LightAccumulator, lit_of},
    clustered_lights::add_clustered_lights,
    directional_light::{DirectionalShadows, add_directional_lights},
    emission::emitted_light,
    indirect_light::add_indirect_light,
    lit::Lit,
    screen_space_light::no_screen_space_light,
    shading_point::shading_point,
}
#import bevy_pbr::{
    clustered_forward::view_fragment_cluster_index,
    decal::clustered::apply_decals,
    forward_io::{FragmentOutput, VertexOutput},
    mesh_view_bindings::view,
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{alpha_discard, main_pass_post_lighting_processing},
    pbr_types::{PbrInput, STANDARD_MATERIAL_FLAGS_UNLIT_BIT},
}

#ifdef AREA_LIGHT_LUTS
#import bevy_lean_deferred::lighting::lights::rect_light::add_rect_lights
#endif

#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::light_layers::enter_mesh
#endif

#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither
#endif

/// Exposed light towards the viewer, before fog.
fn lit_color(pbr: PbrInput) -> vec4<f32> {
    let view_z = (view.view_from_world * pbr.world_position).z;
    let cluster = view_fragment_cluster_index(pbr.frag_coord.xy, view_z, pbr.is_orthographic);
    var point = shading_point(pbr, view_z);
    var lit: Lit;
    add_indirect_light(&point, pbr, cluster, no_screen_space_light(pbr.diffuse_occlusion), &lit);
#ifdef AREA_LIGHT_LUTS
    add_rect_lights(&point, &lit);
#endif
    var shadows: DirectionalShadows;
    var accumulator: LightAccumulator;
    add_directional_lights(&point, &shadows, &accumulator);
    // Tiles cull lights of opaque surfaces alone.
    add_clustered_lights(&point, vec2(0u), cluster, 0u, &accumulator);
    let direct = lit_of(&point, accumulator);
    let light = lit.diffuse + lit.specular + direct.diffuse + direct.specular;
    return vec4(view.exposure * light + emitted_light(pbr), pbr.material.base_color.a);
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
#ifdef VISIBILITY_RANGE_DITHER
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif
#ifdef LIGHT_LAYERS
    enter_mesh(#{MESH_LAYERS}u);
#endif
    var pbr = pbr_input_from_standard_material(in, is_front);
    pbr.material.base_color = alpha_discard(pbr.material, pbr.material.base_color);
    apply_decals(&pbr);
    var out: FragmentOutput;
    if (pbr.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u {
        out.color = lit_color(pbr);
    } else {
        out.color = pbr.material.base_color;
    }
    out.color = main_pass_post_lighting_processing(pbr, out.color);
    return out;
}
