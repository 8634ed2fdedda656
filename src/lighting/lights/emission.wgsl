// Light that a surface emits, as in Bevy's `apply_pbr_lighting`.
#define_import_path bevy_lean_deferred::lighting::lights::emission

#import bevy_pbr::mesh_view_bindings::view
#import bevy_pbr::pbr_types::PbrInput

#ifdef STANDARD_MATERIAL_CLEARCOAT
#import bevy_pbr::lighting::F_Schlick
#endif

/// Exposed.
fn emitted_light(pbr: PbrInput) -> vec3<f32> {
    let emissive = pbr.material.emissive;
    var light = emissive.rgb * pbr.material.base_color.a * mix(1.0, view.exposure, emissive.a);
#ifdef STANDARD_MATERIAL_CLEARCOAT
    // Light emitted beneath the coat. For N·V above 1, F_Schlick is NaN, and so is its product with a coat of 0.
    let NdotV = clamp(dot(pbr.N, pbr.V), 0.0001, 1.0);
    light *= 1.0 - pbr.material.clearcoat * F_Schlick(0.04, 1.0, NdotV);
#endif
    return light;
}
