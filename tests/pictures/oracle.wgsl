// Compares the light of each pixel with that of Bevy's `apply_pbr_lighting` for the same surface, in full floats. Appended to
// `lighting.wgsl`.
#import bevy_lean_deferred::lighting::surface::pbr_input_from_gbuffer
#import bevy_pbr::{
    lighting::F_AB,
    mesh_view_bindings::{lights, view},
    pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing},
}

#ifdef GEOMETRIC_NORMAL
#import bevy_lean_deferred::gbuffer::layout::unpack_has_mesh_normal
#import bevy_lean_deferred::lighting::surface::shadow_normal
#endif

#ifdef GBUFFER_SPECIALIZATION
#import bevy_lean_deferred::gbuffer::layout::specialization as oracle_words
#import bevy_lean_deferred::lighting::surface::is_unlit
#endif

#ifdef LIGHTMAPPED_SURFACES
#import bevy_lean_deferred::lighting::surface::has_lightmap
#endif

#ifdef SHADING_MODEL_RIM
#import bevy_lean_deferred::shading_models::rim::rim_light
#endif

#ifdef CLUSTERED_DECALS_ARE_USABLE
#import bevy_pbr::decal::clustered::apply_decals
#endif

#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
#import bevy_lean_deferred::lighting::visibility::apply_ssao
#endif

/// Light of the pixel by Bevy's functions; alpha is 0 where these, compiled for all kinds of surfaces in view at once, have no
/// result.
fn expected(pixel: Pixel) -> vec4<f32> {
    var pbr = pbr_input_from_gbuffer(pixel);
#ifdef GEOMETRIC_NORMAL
    if !unpack_has_mesh_normal(pixel.surface_word) {
        pbr.world_normal = shadow_normal(pixel.position, pixel.depth, pbr.N);
    }
#endif
#ifdef CLUSTERED_DECALS_ARE_USABLE
    apply_decals(&pbr);
#endif
#ifdef GBUFFER_SPECIALIZATION
    let word = pixel.specialization_word;
    if is_unlit(word) {
        return main_pass_post_lighting_processing(pbr, pbr.material.base_color);
    }
#endif
#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
    apply_ssao(&pbr, pixel.position);
#endif
    var is_known = true;
#ifdef STANDARD_MATERIAL_ANISOTROPY
    // Bevy's anisotropic highlight of strength 0 differs from the isotropic one.
    is_known = oracle_words::unpack_shading_model(word) == oracle_words::ANISOTROPY;
#endif
    var is_lightmapped = false;
#ifdef LIGHTMAPPED_SURFACES
    is_lightmapped = has_lightmap(pixel);
#endif
    // Bevy treats either all surfaces as lightmapped or none.
#ifdef LIGHTMAP
    is_known = is_known && is_lightmapped;
#else
    is_known = is_known && !is_lightmapped;
#endif
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#ifdef ENVIRONMENT_MAP
    // For the part that an environment map transmits, Bevy has another definition, which lighting does not need.
    is_known = is_known && pbr.material.diffuse_transmission == 0.0;
#endif
#endif
    var color = apply_pbr_lighting(pbr);
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    if pbr.material.diffuse_transmission == 0.0 {
        // Bevy adds this much ambient light even without transmission.
        let added = F_AB(1.0, 1.0).y * view.exposure * lights.ambient_color.rgb;
        color = vec4(color.rgb - added, color.a);
    }
#endif
#ifdef SHADING_MODEL_RIM
    if oracle_words::unpack_shading_model(word) == oracle_words::RIM {
        let rim = rim_light(pbr, oracle_words::unpack_arguments(word), is_lightmapped);
        color = vec4(color.rgb + rim, color.a);
    }
#endif
    color = main_pass_post_lighting_processing(pbr, color);
    return vec4(color.rgb, select(0.0, 1.0, is_known));
}

/// The error of `color` in units of the tolerance, with marker values that identify compared pixels.
fn compared(color: vec4<f32>, pixel: Pixel) -> vec4<f32> {
    let expected = expected(pixel);
    let allowed = max(1e-4 * abs(expected.rgb), vec3(1e-5));
    let errors = abs(color.rgb - expected.rgb) / allowed;
    let error = max(errors.r, max(errors.g, errors.b));
    return vec4(min(error, 60000.0), 0.25, 0.125, expected.a);
}
