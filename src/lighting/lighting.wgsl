// Lights every pixel of the packed G-buffer, with Bevy's own lighting functions.
//
// A view with special surfaces is lit by several dispatches of this shader, each compiled for one kind (LIGHTING_VARIANT;
// plain surfaces without): the first goes over all pixels, lights the plain ones and lists the tiles that have others.
#import bevy_lean_deferred::gbuffer::layout
#import bevy_lean_deferred::lighting::bindings::{normal_texture, output_texture, uniforms}
#import bevy_lean_deferred::lighting::surface::{Pixel, pbr_input_from_gbuffer}
#import bevy_lean_deferred::tiles::{pixel_in_view, place_in_tile}
#import bevy_pbr::{
    mesh_view_bindings::{depth_prepass_texture as depth_texture, view},
    pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing},
    pbr_types::PbrInput,
}

#ifdef DEBUG_SHADING_MODEL
#import bevy_lean_deferred::gbuffer::layout::specialization
#endif

#ifdef GBUFFER_WRITTEN
#import bevy_lean_deferred::lighting::bindings::written_texture
#endif

#ifdef GBUFFER_SPECIALIZATION
#import bevy_lean_deferred::lighting::bindings::specialization_texture
#import bevy_lean_deferred::lighting::surface::is_unlit
#import bevy_lean_deferred::lighting::tile_lists::variant_of
#endif

#ifdef SHADING_MODEL_RIM
#import bevy_lean_deferred::gbuffer::layout::specialization::unpack_arguments
#import bevy_lean_deferred::shading_models::rim::rim_light
#endif

#ifdef LISTED_VARIANTS
#import bevy_lean_deferred::lighting::tile_lists::list_tile
#endif

#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::light_layers
#endif

#ifdef DEBUG_MOTION
#ifdef GBUFFER_MOTION
#import bevy_lean_deferred::gbuffer::layout::motion
#import bevy_lean_deferred::lighting::bindings::motion_texture
#endif
#endif

#ifdef DEBUG_VISIBILITY_MASK
#ifdef GBUFFER_VISIBILITY_MASK
#import bevy_lean_deferred::lighting::bindings::visibility_mask_texture
#endif
#endif

#ifdef LIGHTING_VARIANT
#import bevy_lean_deferred::lighting::tile_lists::listed_tile
#endif

#ifdef CLUSTERED_DECALS_ARE_USABLE
#import bevy_pbr::decal::clustered::apply_decals
#endif

#ifdef OCCLUSION_OF_DIRECT_LIGHT
#import bevy_lean_deferred::lighting::direct_light
#endif

#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
#import bevy_pbr::mesh_view_bindings::screen_space_ambient_occlusion_texture
#endif

#ifdef APPLIES_VISIBILITY
#import bevy_pbr::{lighting::perceptualRoughnessToRoughness, ssao_utils::ssao_multibounce}
#endif

#ifdef LEAN_AMBIENT_OCCLUSION
#import bevy_lean_deferred::ambient_occlusion::filter::filtered_occlusion
#import bevy_lean_deferred::lighting::bindings::{
    nearest_sampler, occlusion_texture, occlusion_view,
}
#endif

#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
fn apply_ssao(pbr: ptr<function, PbrInput>, pixel: vec2<i32>) {
    let ssao = textureLoad(screen_space_ambient_occlusion_texture, pixel, 0).r;
    apply_visibility(pbr, ssao, ssao_multibounce(ssao, (*pbr).material.base_color.rgb));
}
#endif

#ifdef LEAN_AMBIENT_OCCLUSION
/// Returns the visibility.
fn apply_occlusion(pbr: ptr<function, PbrInput>, pixel: vec2<i32>, depth: f32) -> f32 {
    let occlusion = filtered_occlusion(
        occlusion_texture,
        nearest_sampler,
        depth_texture,
        occlusion_view,
        pixel - vec2<i32>(uniforms.viewport_origin),
        depth,
    );
    let visibility = 1.0 - occlusion;
#ifdef OCCLUSION_MULTIBOUNCE
    apply_visibility(pbr, visibility, ssao_multibounce(visibility, (*pbr).material.base_color.rgb));
#else
    apply_visibility(pbr, visibility, vec3(visibility));
#endif
    return visibility;
}
#endif

#ifdef APPLIES_VISIBILITY
/// As Bevy's `pbr_fragment` applies its own occlusion.
fn apply_visibility(pbr: ptr<function, PbrInput>, visibility: f32, tinted: vec3<f32>) {
    (*pbr).diffuse_occlusion = min((*pbr).diffuse_occlusion, tinted);
    // Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering".
    let n_dot_v = max(dot((*pbr).N, (*pbr).V), 0.0001);
    let roughness = perceptualRoughnessToRoughness((*pbr).material.perceptual_roughness);
    let specular = saturate(pow(n_dot_v + visibility, exp2(-16.0 * roughness - 1.0)) - 1.0 + visibility);
    (*pbr).specular_occlusion = min((*pbr).specular_occlusion, specular);
}
#endif  // APPLIES_VISIBILITY

#ifdef DEBUG_SHADING_MODEL
/// Plain surfaces are grey: black at a specular constant of 0, white at 2.
fn shading_model_color(word: u32) -> vec3<f32> {
    switch specialization::unpack_shading_model(word) {
        case specialization::SUBSURFACE: { return vec3(0.9, 0.4, 0.3); }
        case specialization::ANISOTROPY: { return vec3(0.9, 0.8, 0.1); }
        case specialization::RIM: { return vec3(0.2, 0.8, 0.9); }
        case specialization::CLEARCOAT: { return vec3(0.1, 0.2, 0.9); }
        case specialization::BACKLIGHT: { return vec3(0.2, 0.8, 0.2); }
        case specialization::UNLIT: { return vec3(0.8, 0.1, 0.8); }
        default: { return vec3(specialization::unpack_reflectance(word) / 2.0); }
    }
}
#endif

#ifdef DEBUG_MOTION
fn motion_color(pixel: Pixel) -> vec3<f32> {
#ifdef GBUFFER_MOTION
    if (pixel.written & layout::MOTION_WRITTEN) == 0u {
        return vec3(0.0);
    }
    let word = textureLoad(motion_texture, pixel.position, 0).r;
    return vec3(saturate(0.5 + 5.0 * motion::unpack_motion(word)), 0.5);
#else
    return vec3(0.0);
#endif
}
#endif

#ifdef DEBUG_VISIBILITY_MASK
fn visibility_mask_color(pixel: Pixel) -> vec3<f32> {
#ifdef GBUFFER_VISIBILITY_MASK
    if (pixel.written & layout::VISIBILITY_MASK_WRITTEN) != 0u {
        let mask = textureLoad(visibility_mask_texture, pixel.position, 0).r;
        // Neighbouring masks get colours far apart (Knuth 1973, "The Art of Computer Programming" 3, 6.4).
        return unpack4x8unorm(mask * 2654435769u).gba;
    }
#endif
    return vec3(0.5);
}
#endif

#ifdef DEBUG_VIEW
fn debug_color(pbr: PbrInput, pixel: Pixel) -> vec3<f32> {
#ifdef DEBUG_ALBEDO
    return pbr.material.base_color.rgb;
#else ifdef DEBUG_METALLIC
    return vec3(pbr.material.metallic);
#else ifdef DEBUG_OCCLUSION
    return pbr.diffuse_occlusion;
#else ifdef DEBUG_NORMAL
    return pbr.N * 0.5 + 0.5;
#else ifdef DEBUG_ROUGHNESS
    return vec3(pbr.material.perceptual_roughness);
#else ifdef DEBUG_GEOMETRIC_NORMAL
    return pbr.world_normal * 0.5 + 0.5;
#else ifdef DEBUG_EMISSIVE
    return pbr.material.emissive.rgb;
#else ifdef DEBUG_SHADING_MODEL
    return shading_model_color(pixel.specialization_word);
#else ifdef DEBUG_MOTION
    return motion_color(pixel);
#else ifdef DEBUG_VISIBILITY_MASK
    return visibility_mask_color(pixel);
#else
    let z = (view.view_from_world * pbr.world_position).z;
    return vec3(1.0 / (1.0 + abs(z)));
#endif
}
#endif

fn light(pixel: Pixel) -> vec4<f32> {
    var pbr = pbr_input_from_gbuffer(pixel);
#ifdef DEBUG_VIEW
    return vec4(debug_color(pbr, pixel), 1.0);
#else
#ifdef LIGHT_LAYERS
    light_layers::enter_pixel(pixel);
#endif
#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
    apply_ssao(&pbr, pixel.position);
#endif
#ifdef CLUSTERED_DECALS_ARE_USABLE
    apply_decals(&pbr);
#endif
#ifdef LEAN_AMBIENT_OCCLUSION
    let visibility = apply_occlusion(&pbr, pixel.position, pixel.depth);
#endif
#ifdef OCCLUSION_DEBUG_VIEW
    return vec4(vec3(visibility), 1.0);
#else
#ifdef GBUFFER_SPECIALIZATION
#ifndef LIGHTING_VARIANT
    if is_unlit(pixel.specialization_word) {
        return main_pass_post_lighting_processing(pbr, pbr.material.base_color);
    }
#endif
#endif
    var color = apply_pbr_lighting(pbr);
#ifdef SHADING_MODEL_RIM
    let rim = rim_light(pbr, unpack_arguments(pixel.specialization_word));
    color = vec4(color.rgb + rim, color.a);
#endif
#ifdef OCCLUSION_OF_DIRECT_LIGHT
    direct_light::leave_others_out();
    // These occlude what irradiance volumes give. What the surface itself emits is no direct light either.
    pbr.diffuse_occlusion = vec3(0.0);
    pbr.specular_occlusion = 0.0;
    pbr.material.emissive = vec4(0.0);
    pbr.lightmap_light = vec3(0.0);
    let hidden = occlusion_view.direct_light_affect * (1.0 - visibility);
    color = vec4(color.rgb - hidden * apply_pbr_lighting(pbr).rgb, color.a);
#endif
    return main_pass_post_lighting_processing(pbr, color);
#endif  // OCCLUSION_DEBUG_VIEW
#endif
}

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
    pixel.has_geometry = pixel.depth != 0.0;
#endif
    pixel.normal_word = textureLoad(normal_texture, pixel.position, 0).r;
#ifndef DEPTH_TELLS_GEOMETRY
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

#ifdef LIGHTING_VARIANT
@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let tile = listed_tile(workgroup.xy);
    if !tile.is_listed {
        return;
    }
    let pixel = read_pixel(tile.origin + place_in_tile(invocation));
    if pixel.has_geometry && variant_of(pixel.specialization_word) == #{LIGHTING_VARIANT}u {
        textureStore(output_texture, pixel.position, light(pixel));
    }
}
#else
@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(num_workgroups) tiles: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let place = pixel_in_view(tile.xy, tiles.xy, uniforms.row_stride, invocation);
    let pixel = read_pixel(place);
#ifdef LISTED_VARIANTS
    let variant = select(0u, variant_of(pixel.specialization_word), pixel.has_geometry);
    list_tile(place - place_in_tile(invocation), variant, invocation);
    if variant != 0u {
        return;
    }
#endif
    if any(place >= uniforms.viewport_size) {
        return;
    }
    if pixel.has_geometry {
        textureStore(output_texture, pixel.position, light(pixel));
        return;
    }
#ifdef OCCLUSION_DEBUG_VIEW
    textureStore(output_texture, pixel.position, vec4(1.0));
#else
    if uniforms.writes_background != 0u {
        textureStore(output_texture, pixel.position, uniforms.background);
    }
#endif
}
#endif  // LIGHTING_VARIANT
