// Light of a surface in Bevy's passes, by the crate's loop over lights in place of Bevy's. All bindings are Bevy's, but for the layers of
// lights. Without the definitions of `definitions.rs`, Bevy's loop lights the surface.
#define_import_path bevy_lean_deferred::lighting::forward::light

#ifdef FORWARD_MESH
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
    mesh_view_bindings::view,
    pbr_types::PbrInput,
}

#ifdef AREA_LIGHT_LUTS
#import bevy_lean_deferred::lighting::lights::rect_light::add_rect_lights
#endif
#else
#import bevy_pbr::pbr_functions::apply_pbr_lighting
#import bevy_pbr::pbr_types::PbrInput
#endif  // FORWARD_MESH

#ifdef FORWARD_MESH
/// Exposed light towards the viewer, before fog: in place of Bevy's `apply_pbr_lighting`. Without specular transmission; the normal of a
/// clear coat is `N`.
fn apply_lean_lighting(pbr: PbrInput) -> vec4<f32> {
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
#else   // FORWARD_MESH
fn apply_lean_lighting(pbr: PbrInput) -> vec4<f32> {
    return apply_pbr_lighting(pbr);
}
#endif  // FORWARD_MESH
