// Lights every pixel of the packed G-buffer.
//
// A view with special surfaces is lit by two dispatches of this shader: the first goes over all tiles, lights those that
// have plain surfaces only, and lists the others; the second, compiled for the kinds of special surfaces that the view
// has (VISITED_VARIANTS), goes over that list.
#import bevy_lean_deferred::gbuffer::layout
#import bevy_lean_deferred::lighting::bindings::{
    normal_texture, output_texture, surface_texture, uniforms,
}
#import bevy_lean_deferred::lighting::surface::{Pixel, pbr_input_from_gbuffer}
#import bevy_lean_deferred::tiles::{pixel_in_view, place_in_tile}
#import bevy_pbr::{
    clustered_forward::view_fragment_cluster_index,
    mesh_view_bindings::{depth_prepass_texture as depth_texture, view},
    pbr_functions::main_pass_post_lighting_processing,
    pbr_types::PbrInput,
}

#ifdef DEBUG_VIEW
#import bevy_lean_deferred::lighting::debug_view::debug_color
#endif

#ifdef SHOWS_LIGHT
#import bevy_lean_deferred::lighting::lights::{
    brdf::{Gathered, lit_of},
    directional_light::{DirectionalShadows, add_directional_lights},
    indirect_light::add_indirect_light,
    lit::Lit,
    shading_point::{NO_CLUSTER, ShadingPoint, shading_point},
}
#endif

#ifdef DIRECTIONAL_SHADOW_MAPS
#import bevy_lean_deferred::lighting::lights::directional_light::find_directional_shadows
#import bevy_lean_deferred::lighting::surface::receives_shadows
#endif

#ifdef CLUSTERED_LIGHTS
#import bevy_lean_deferred::lighting::lights::clustered_lights::add_clustered_lights
#endif

#ifdef AREA_LIGHT_LUTS
#import bevy_lean_deferred::lighting::lights::rect_light::add_rect_lights
#endif

#ifdef GBUFFER_WRITTEN
#import bevy_lean_deferred::lighting::bindings::written_texture
#endif

#ifdef GBUFFER_SPECIALIZATION
#import bevy_lean_deferred::lighting::bindings::specialization_texture
#import bevy_lean_deferred::lighting::surface::is_unlit
#endif

#ifdef STANDARD_MATERIAL_CLEARCOAT
#import bevy_pbr::lighting::F_Schlick
#endif

#ifdef SHADING_MODEL_RIM
#import bevy_lean_deferred::gbuffer::layout::specialization::{RIM, unpack_arguments, unpack_shading_model}
#import bevy_lean_deferred::shading_models::rim::rim_light
#endif

#ifdef LISTED_VARIANTS
#import bevy_lean_deferred::lighting::tile_list::{list_tile, variant_of}
#endif

#ifdef VISITED_VARIANTS
#import bevy_lean_deferred::lighting::tile_list::listed_tile
#endif

#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::light_layers
#endif

#ifdef CLUSTERED_DECALS_ARE_USABLE
#import bevy_pbr::decal::clustered::apply_decals
#endif

#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
#import bevy_lean_deferred::lighting::visibility::apply_ssao
#endif

#ifdef LEAN_AMBIENT_OCCLUSION
#import bevy_lean_deferred::lighting::bindings::occlusion_view
#import bevy_lean_deferred::lighting::visibility::apply_occlusion
#endif

#ifdef SHOWS_LIGHT
/// What the pixel shows. Lights find the surface together: to be called by all invocations of a tile, whose first pixel is
/// `corner`, also by those whose pixel has no geometry. `member` counts them, in the subgroup or else in the workgroup.
fn shade(pixel: Pixel, corner: vec2<u32>, member: u32) -> vec4<f32> {
    var pbr: PbrInput;
    var point: ShadingPoint;
    var cluster = NO_CLUSTER;
    // Exposed.
    var color: vec3<f32>;
    var gathered: Gathered;
    // What occlusion leaves of direct light.
    var direct_visibility = 1.0;
    if pixel.has_geometry {
        var shadows: DirectionalShadows;
#ifdef DIRECTIONAL_SHADOW_MAPS
        if receives_shadows(pixel) {
            find_directional_shadows(pixel, &shadows);
        }
#endif
        pbr = pbr_input_from_gbuffer(pixel);
#ifdef LIGHT_LAYERS
        light_layers::enter_pixel(pixel);
#endif
#ifdef CLUSTERED_DECALS_ARE_USABLE
        apply_decals(&pbr);
#endif
        color = pbr.material.base_color.rgb;
#ifdef GBUFFER_SPECIALIZATION
        let has_light = !is_unlit(pixel.specialization_word);
#else
        let has_light = true;
#endif
        if has_light {
#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
            apply_ssao(&pbr, pixel.position);
#endif
#ifdef LEAN_AMBIENT_OCCLUSION
            let visibility = apply_occlusion(&pbr, pixel.position, pixel.depth);
#ifdef OCCLUSION_OF_DIRECT_LIGHT
            direct_visibility = 1.0 - occlusion_view.direct_light_affect * (1.0 - visibility);
#endif
#endif
            let view_z = (view.view_from_world * pbr.world_position).z;
            cluster = view_fragment_cluster_index(pbr.frag_coord.xy, view_z, pbr.is_orthographic);
            point = shading_point(pbr, pixel, view_z);
            // What needs more of the surface than lights do comes first: less is carried through their loops.
            var lit: Lit;
            add_indirect_light(&point, pbr, cluster, &lit);
            color = view.exposure * (lit.diffuse + lit.specular) + emitted(pbr, pixel);
#ifdef AREA_LIGHT_LUTS
            lit = Lit();
            add_rect_lights(&point, &lit);
            color += view.exposure * direct_visibility * (lit.diffuse + lit.specular);
#endif
            add_directional_lights(&point, &shadows, &gathered);
        }
    }
#ifdef CLUSTERED_LIGHTS
    add_clustered_lights(&point, corner, cluster, member, &gathered);
#endif
    if !pixel.has_geometry {
        return vec4(0.0);
    }
    if cluster != NO_CLUSTER {
        let lit = lit_of(&point, gathered);
        color += view.exposure * direct_visibility * (lit.diffuse + lit.specular);
    }
    return main_pass_post_lighting_processing(pbr, vec4(color, 1.0));
}

/// What a surface emits, and catches along its rim; exposed.
fn emitted(pbr: PbrInput, pixel: Pixel) -> vec3<f32> {
    let emissive = pbr.material.emissive;
    var light = emissive.rgb * pbr.material.base_color.a * mix(1.0, view.exposure, emissive.a);
#ifdef STANDARD_MATERIAL_CLEARCOAT
    // The coat is on top.
    let NdotV = max(dot(pbr.N, pbr.V), 0.0001);
    light *= 1.0 - pbr.material.clearcoat * F_Schlick(0.04, 1.0, NdotV);
#endif
#ifdef SHADING_MODEL_RIM
    if unpack_shading_model(pixel.specialization_word) == RIM {
        light += rim_light(pbr, unpack_arguments(pixel.specialization_word));
    }
#endif
    return light;
}
#else   // SHOWS_LIGHT
/// What the pixel shows in place of light.
fn shade(pixel: Pixel, corner: vec2<u32>, member: u32) -> vec4<f32> {
    var pbr = pbr_input_from_gbuffer(pixel);
#ifdef OCCLUSION_DEBUG_VIEW
    return vec4(vec3(apply_occlusion(&pbr, pixel.position, pixel.depth)), 1.0);
#else
    return vec4(debug_color(pbr, pixel), 1.0);
#endif
}
#endif  // SHOWS_LIGHT

/// Reads the pixel at `place` of the viewport; without geometry if that lies outside of it.
fn read_pixel(place: vec2<u32>) -> Pixel {
    var pixel: Pixel;
    if any(place >= uniforms.viewport_size) {
        return pixel;
    }
    pixel.position = vec2<i32>(uniforms.viewport_origin + place);
    pixel.depth = textureLoad(depth_texture, pixel.position, 0);
#ifdef DEPTH_TELLS_GEOMETRY
    // The G-buffer was not cleared: without depth it holds anything.
    if pixel.depth == 0.0 {
        return pixel;
    }
#endif
    pixel.normal_word = textureLoad(normal_texture, pixel.position, 0).r;
    pixel.surface_word = textureLoad(surface_texture, pixel.position, 0).r;
#ifdef DEPTH_TELLS_GEOMETRY
    pixel.has_geometry = true;
#else
    pixel.has_geometry = pixel.normal_word != layout::NO_GEOMETRY;
#endif
#ifdef GBUFFER_WRITTEN
    // Cleared in each frame.
    pixel.written = textureLoad(written_texture, pixel.position, 0).r;
#endif
#ifdef GBUFFER_SPECIALIZATION
    if (pixel.written & layout::SPECIALIZATION_WRITTEN) != 0u {
        pixel.specialization_word = textureLoad(specialization_texture, pixel.position, 0).r;
    }
#endif
    return pixel;
}

#ifdef VISITED_VARIANTS
@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
#ifdef LIGHT_CULLING_BY_SUBGROUPS
    @builtin(subgroup_invocation_id) member: u32,
#endif
) {
    let tile = listed_tile(workgroup.xy);
    if !tile.is_listed {
        return;
    }
#ifndef LIGHT_CULLING_BY_SUBGROUPS
    let member = invocation;
#endif
    let place = tile.origin + place_in_tile(invocation);
    let pixel = read_pixel(place);
    light_tile(pixel, place, tile.origin, member);
}
#else   // VISITED_VARIANTS
@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(num_workgroups) tiles: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
#ifdef LIGHT_CULLING_BY_SUBGROUPS
    @builtin(subgroup_invocation_id) member: u32,
#endif
) {
#ifndef LIGHT_CULLING_BY_SUBGROUPS
    let member = invocation;
#endif
    let place = pixel_in_view(tile.xy, tiles.xy, uniforms.row_stride, invocation);
    let corner = place - place_in_tile(invocation);
    let pixel = read_pixel(place);
#ifdef LISTED_VARIANTS
    let variant = select(0u, variant_of(pixel.specialization_word), pixel.has_geometry);
    if list_tile(corner, variant, invocation) {
        return;
    }
#endif
    light_tile(pixel, place, corner, member);
}
#endif  // VISITED_VARIANTS

/// Writes what the pixel at `place` shows.
fn light_tile(pixel: Pixel, place: vec2<u32>, corner: vec2<u32>, member: u32) {
    let color = shade(pixel, uniforms.viewport_origin + corner, member);
    if pixel.has_geometry {
        textureStore(output_texture, pixel.position, color);
    } else {
        write_background(place);
    }
}

/// Where nothing is.
fn write_background(place: vec2<u32>) {
    if any(place >= uniforms.viewport_size) {
        return;
    }
    let position = vec2<i32>(uniforms.viewport_origin + place);
#ifdef OCCLUSION_DEBUG_VIEW
    textureStore(output_texture, position, vec4(1.0));
#else
    if uniforms.writes_background != 0u {
        textureStore(output_texture, position, uniforms.background);
    }
#endif
}
