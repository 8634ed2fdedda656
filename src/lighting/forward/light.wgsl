// Light of a surface in Bevy's passes, by the crate's loop over lights in place of Bevy's. All bindings are Bevy's, but for the layers of
// lights and for reflections. Without the definitions of `definitions.rs`, Bevy's loop lights the surface.
#define_import_path bevy_lean_deferred::lighting::forward::light

#import bevy_lean_deferred::lighting::forward::reflected_light::lean_reflected_light

#ifdef FORWARD_MESH
#import bevy_lean_deferred::lighting::lights::{
    brdf::{LightAccumulator, lit_of},
    clustered_lights::add_clustered_lights,
    directional_light::{DirectionalShadows, add_directional_lights},
    emission::emitted_light,
    indirect_light::{add_indirect_light, surroundings_of},
    lit::Lit,
    screen_space_light::no_screen_space_light,
    shading_point::{set_material, shading_point},
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

/// The picture in the mirror of a surface, or of its coat.
fn reflected_light_of(pbr: PbrInput) -> vec4<f32> {
#ifdef FORWARD_REFLECTIONS
    var roughness = pbr.material.perceptual_roughness;
#ifdef STANDARD_MATERIAL_CLEARCOAT
    if pbr.material.clearcoat > 0.0 {
        roughness = pbr.material.clearcoat_perceptual_roughness;
    }
#endif
    return lean_reflected_light(pbr.world_position.xyz, pbr.N, roughness);
#else
    return vec4(0.0);
#endif
}

/// Exposed light towards the viewer, before fog: in place of Bevy's `apply_pbr_lighting`. Without specular transmission; the normal of a
/// clear coat is `N`. With reflections of the picture, where the view has them on forward meshes.
fn apply_lean_lighting(pbr: PbrInput) -> vec4<f32> {
    return apply_lean_lighting_with_reflection(pbr, reflected_light_of(pbr));
}

#ifdef FORWARD_MESH
/// As `apply_lean_lighting`, with a `reflected` light as `lean_reflected_light` returns it: it is multiplied by Fresnel's terms, and replaces
/// the environment by its confidence. Ignored where the view has no reflections on forward meshes.
fn apply_lean_lighting_with_reflection(pbr: PbrInput, reflected: vec4<f32>) -> vec4<f32> {
    let view_z = (view.view_from_world * pbr.world_position).z;
    let cluster = view_fragment_cluster_index(pbr.frag_coord.xy, view_z, pbr.is_orthographic);
    var point = shading_point(pbr, view_z);
    var shadows: DirectionalShadows;
    var accumulator: LightAccumulator;
    add_directional_lights(&point, &shadows, &accumulator);
    // Tiles cull lights of opaque surfaces alone.
    add_clustered_lights(&point, vec2(0u), cluster, 0u, &accumulator);
    let around = surroundings_of(&point, cluster);
    // After the loops, so that fewer registers are live in them.
    set_material(&point, pbr.material);
    let direct = lit_of(&point, accumulator);
    var light = direct.diffuse + direct.specular;
    var found = no_screen_space_light(pbr.diffuse_occlusion);
#ifdef FORWARD_REFLECTIONS
    found.radiance = reflected.rgb / view.exposure;
    found.confidence = saturate(reflected.a);
#endif
    var lit: Lit;
    add_indirect_light(&point, pbr, around, found, &lit);
    light += lit.diffuse + lit.specular;
#ifdef AREA_LIGHT_LUTS
    lit = Lit();
    add_rect_lights(&point, &lit);
    light += lit.diffuse + lit.specular;
#endif
    return vec4(view.exposure * light + emitted_light(pbr), pbr.material.base_color.a);
}
#else   // FORWARD_MESH
fn apply_lean_lighting_with_reflection(pbr: PbrInput, reflected: vec4<f32>) -> vec4<f32> {
    return apply_pbr_lighting(pbr);
}
#endif  // FORWARD_MESH
