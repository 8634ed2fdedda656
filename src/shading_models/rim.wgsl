// Rim light along silhouettes.
//
// | bits, low to high | |
// |---|---|
// | 4, 4, 4 | colour R, G, B (square roots) |
// | 5 | exponent, 1 to 16 (quadratic) |
//
// The exponent is off by at most 0.48.
#define_import_path bevy_lean_deferred::shading_models::rim

#import bevy_lean_deferred::gbuffer::layout::{quantize, quantize_roots}

/// Packs the arguments of rim light: colour 0 to 1, exponent 1 to 16.
fn pack_rim(color: vec3<f32>, exponent: f32) -> u32 {
    let codes = quantize_roots(color, vec3(15.0));
    let root = sqrt(max((exponent - 1.0) / 15.0, 0.0));
    return codes.r | (codes.g << 4u) | (codes.b << 8u) | (quantize(root, 31.0) << 12u);
}

/// Colour of rim light, 0 to 1.
fn unpack_rim_color(arguments: u32) -> vec3<f32> {
    let codes = vec3(arguments & 0xfu, (arguments >> 4u) & 0xfu, (arguments >> 8u) & 0xfu);
    let root = vec3<f32>(codes) / 15.0;
    return root * root;
}

/// Exponent of rim light, 1 to 16.
fn unpack_rim_exponent(arguments: u32) -> f32 {
    let root = f32((arguments >> 12u) & 0x1fu) / 31.0;
    return 1.0 + 15.0 * root * root;
}

#ifdef SHADING_MODEL_RIM
#import bevy_pbr::{
    clustered_forward as clustering,
    mesh_view_bindings::{lights, view},
    pbr_types::PbrInput,
}

#ifdef ENVIRONMENT_MAP
#import bevy_lean_deferred::lighting::lights::environment::radiances_of
#import bevy_pbr::lighting::LayerLightingInput
#endif

#ifdef IRRADIANCE_VOLUME
#import bevy_lean_deferred::lighting::lights::irradiance_volumes::irradiance_of_volumes
#endif

/// The dedicated rim term of Mitchell, Francke and Eng 2007, "Illustrative Rendering in Team Fortress 2":
/// `(n · u) (1 - n · v)^exponent color a(v)`, where `u` points up and `a(v)`, here `behind`, is the light along the eye's ray from behind
/// the surface. Negative products are clamped to 0. Colour and exponent are unpacked from `arguments`. Exposed, like the result of
/// `apply_pbr_lighting`.
fn rim_light(in: PbrInput, arguments: u32, behind: vec3<f32>) -> vec3<f32> {
    let color = unpack_rim_color(arguments);
    let exponent = unpack_rim_exponent(arguments);
    // Clamp: shading normals may face away from the viewer.
    let fresnel = pow(1.0 - saturate(dot(in.N, in.V)), exponent);
    let up = saturate(in.N.y);
    return view.exposure * (color * (up * fresnel) * in.diffuse_occlusion * behind);
}

/// The part of the light from behind that is ambient light.
fn ambient_light_behind(is_lightmapped: bool) -> vec3<f32> {
    if is_lightmapped && lights.ambient_light_affects_lightmapped_meshes == 0u {
        return vec3(0.0);
    }
    return lights.ambient_color.rgb;
}

/// Mean light from behind the surface, in Bevy's passes: ambient light, and either irradiance volumes or environment maps, chosen like
/// Bevy's diffuse light. Lighting of the G-buffer looks it up with the pixel's other indirect light.
fn light_behind(in: PbrInput, is_lightmapped: bool) -> vec3<f32> {
    let view_z = (view.view_from_world * in.world_position).z;
    let cluster = clustering::view_fragment_cluster_index(in.frag_coord.xy, view_z, in.is_orthographic);
    var ranges = clustering::unpack_clusterable_object_index_ranges(cluster);
    var light = ambient_light_behind(is_lightmapped);
    var found_diffuse = is_lightmapped;
#ifdef IRRADIANCE_VOLUME
    if !found_diffuse {
        light += irradiance_of_volumes(in.world_position.xyz, -in.V, &ranges);
        found_diffuse = true;
    }
#endif
#ifdef ENVIRONMENT_MAP
    // At full roughness, the radiance that is sampled with the irradiance is cheap.
    let input = LayerLightingInput(-in.V, -in.V, 1.0, 1.0, 1.0);
    light += radiances_of(input, &ranges, in.world_position.xyz, found_diffuse).irradiance;
#endif
    return light;
}
#endif  // SHADING_MODEL_RIM
