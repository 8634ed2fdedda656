// Applies ambient occlusion to indirect light.
#define_import_path bevy_lean_deferred::lighting::visibility

#import bevy_pbr::pbr_types::PbrInput

#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
#import bevy_pbr::mesh_view_bindings::screen_space_ambient_occlusion_texture
#endif

#ifdef APPLIES_VISIBILITY
#import bevy_pbr::{lighting::perceptualRoughnessToRoughness, ssao_utils::ssao_multibounce}
#endif

#ifdef LEAN_AMBIENT_OCCLUSION
#import bevy_lean_deferred::lighting::bindings::{nearest_sampler, occlusion_texture, uniforms}
#import bevy_lean_deferred::lighting::parts
#import bevy_lean_deferred::occlusion_filter::{FilterKind, OcclusionFilter, compiled_kind, filtered_occlusion}
#import bevy_pbr::mesh_view_bindings::depth_prepass_texture as depth_texture
#endif

#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
fn apply_ssao(pbr: ptr<function, PbrInput>, pixel: vec2<i32>) {
    let ssao = textureLoad(screen_space_ambient_occlusion_texture, pixel, 0).r;
    apply_visibility(pbr, ssao, ssao_multibounce(ssao, (*pbr).material.base_color.rgb));
}
#endif

#ifdef LEAN_AMBIENT_OCCLUSION
/// The filter of the view's occlusion.
fn filter_kind() -> FilterKind {
#ifdef SUPERSET
    return FilterKind(
        parts::has(parts::OCCLUSION_HALF),
        parts::has(parts::OCCLUSION_WIDE),
        parts::has(parts::OCCLUSION_EDGE_AWARE),
    );
#else
    return compiled_kind();
#endif
}

/// Applies occlusion, also to the light of lightmaps, and returns the visibility.
fn apply_occlusion(pbr: ptr<function, PbrInput>, pixel: vec2<i32>, depth: f32) -> f32 {
    let parameters = OcclusionFilter(
        uniforms.occlusion_edge,
        uniforms.occlusion_intensity,
        uniforms.viewport_origin,
        uniforms.viewport_size,
    );
    let occlusion = filtered_occlusion(
        occlusion_texture,
        nearest_sampler,
        depth_texture,
        parameters,
        filter_kind(),
        pixel - vec2<i32>(uniforms.viewport_origin),
        depth,
    );
    let visibility = 1.0 - occlusion;
    var tinted = vec3(visibility);
#ifdef OCCLUSION_MULTIBOUNCE
    if parts::has(parts::OCCLUSION_MULTIBOUNCE) {
        tinted = ssao_multibounce(visibility, (*pbr).material.base_color.rgb);
    }
#endif
    apply_visibility(pbr, visibility, tinted);
#ifdef LIGHTMAPPED_SURFACES
    // Open surfaces keep their light exactly: multiple bounces may add up to slightly more than 1.
    (*pbr).lightmap_light *= 1.0 - uniforms.occlusion_of_baked_light * saturate(1.0 - tinted);
#endif
    return visibility;
}
#endif

#ifdef APPLIES_VISIBILITY
/// Applies visibility as Bevy's `pbr_fragment` does.
fn apply_visibility(pbr: ptr<function, PbrInput>, visibility: f32, tinted: vec3<f32>) {
    (*pbr).diffuse_occlusion = min((*pbr).diffuse_occlusion, tinted);
    // Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering".
    let n_dot_v = max(dot((*pbr).N, (*pbr).V), 0.0001);
    let roughness = perceptualRoughnessToRoughness((*pbr).material.perceptual_roughness);
    let specular = saturate(pow(n_dot_v + visibility, exp2(-16.0 * roughness - 1.0)) - 1.0 + visibility);
    (*pbr).specular_occlusion = min((*pbr).specular_occlusion, specular);
}
#endif  // APPLIES_VISIBILITY
