// Light from everywhere: lightmaps, irradiance volumes, environment maps with reflection probes, ambient light; in Bevy's
// order, in which the first that gives diffuse light is the last but for ambient light.
#define_import_path bevy_lean_deferred::lighting::lights::indirect_light

#import bevy_lean_deferred::lighting::lights::lit::Lit
#import bevy_lean_deferred::lighting::lights::shading_point::ShadingPoint
#import bevy_pbr::{
    clustered_forward::{ClusterableObjectIndexRanges, unpack_clusterable_object_index_ranges},
    lighting::{EnvBRDFApprox, F_AB},
    mesh_view_bindings::lights,
    pbr_types::PbrInput,
}

#ifdef ENVIRONMENT_MAP
#import bevy_pbr::{
    environment_map::{compute_multiscatter, compute_radiances},
    lighting::LayerLightingInput,
}
#endif

#ifdef IRRADIANCE_VOLUME
#import bevy_pbr::irradiance_volume::irradiance_volume_light
#endif

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#import bevy_lean_deferred::lighting::lights::shading_point::transmits
#endif

/// Occluded as `pbr` says. `cluster` is the pixel's.
fn add_indirect_light(
    point: ptr<function, ShadingPoint>,
    pbr: PbrInput,
    cluster: u32,
    lit: ptr<function, Lit>,
) {
    var found_diffuse = false;
    var is_lightmapped = false;
#ifdef LIGHTMAP
    is_lightmapped = (*point).is_lightmapped;
    found_diffuse = is_lightmapped;
    if is_lightmapped {
        (*lit).diffuse += pbr.lightmap_light * (*point).diffuse_color;
    }
#endif
    var ranges = unpack_clusterable_object_index_ranges(cluster);
#ifdef IRRADIANCE_VOLUME
    if !found_diffuse {
        let irradiance = irradiance_volume_light((*point).position, (*point).N, &ranges);
        (*lit).diffuse += irradiance * (*point).diffuse_color * pbr.diffuse_occlusion;
        found_diffuse = true;
    }
#endif
#ifdef ENVIRONMENT_MAP
    add_environment(point, pbr, &ranges, found_diffuse, lit);
#endif
    if !is_lightmapped || lights.ambient_light_affects_lightmapped_meshes != 0u {
        add_ambient_light(point, pbr.diffuse_occlusion, lit);
    }
}

/// As Bevy's `ambient_light`.
fn add_ambient_light(point: ptr<function, ShadingPoint>, occlusion: vec3<f32>, lit: ptr<function, Lit>) {
    let color = lights.ambient_color.rgb;
    // Of all pixels: ambient light is off.
    if all(color == vec3(0.0)) {
        return;
    }
    let diffuse = EnvBRDFApprox((*point).diffuse_color, F_AB(1.0, (*point).NdotV));
    let specular = EnvBRDFApprox((*point).F_normal, (*point).F_ab) * (*point).F_grazing;
    (*lit).diffuse += diffuse * color * occlusion;
    (*lit).specular += specular * color * occlusion;
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    if transmits(point) {
        (*lit).diffuse += EnvBRDFApprox((*point).transmitted_color, F_AB(1.0, 1.0)) * color;
    }
#endif
}

#ifdef ENVIRONMENT_MAP
/// As Bevy's `environment_map_light`.
fn add_environment(
    point: ptr<function, ShadingPoint>,
    pbr: PbrInput,
    ranges: ptr<function, ClusterableObjectIndexRanges>,
    found_diffuse: bool,
    lit: ptr<function, Lit>,
) {
    let mirrored = reflect(-(*point).V, (*point).N);
    var layer = LayerLightingInput(
        (*point).N, mirrored, (*point).NdotV, (*point).perceptual_roughness, (*point).roughness,
    );
#ifdef STANDARD_MATERIAL_ANISOTROPY
    if (*point).is_anisotropic {
        bend(point, &layer);
    }
#endif
    let radiances = compute_radiances(layer, ranges, (*point).position, found_diffuse);
    var irradiance = radiances.irradiance;
    if found_diffuse {
        irradiance = vec3(0.0);
    }
    let F_ab = (*point).F_ab;
    let scattered_again = 1.0 - (F_ab.x + F_ab.y);
    let dielectric = compute_multiscatter((*point).F0_dielectric, F_ab, scattered_again, (*point).F_grazing);
    let metallic = compute_multiscatter((*point).F0_metallic, F_ab, scattered_again, (*point).F_grazing);
    let once = mix(dielectric.FssEss, metallic.FssEss, (*point).metallic);
    let again = mix(dielectric.FmsEms, metallic.FmsEms, (*point).metallic);
    var diffuse = (again + (*point).diffuse_color * dielectric.Edss) * irradiance;
    var specular = once * radiances.radiance;
#ifdef STANDARD_MATERIAL_CLEARCOAT
    if (*point).clearcoat > 0.0 {
        let fresnel = (0.04 + 0.96 * (*point).view_fresnel) * (*point).clearcoat;
        layer.N = (*point).N;
        layer.R = mirrored;
        layer.perceptual_roughness = (*point).clearcoat_perceptual_roughness;
        layer.roughness = (*point).clearcoat_roughness;
        let coat = compute_radiances(layer, ranges, (*point).position, true).radiance;
        let passed = 1.0 - fresnel;
        diffuse *= passed;
        specular = specular * (passed * passed) + coat * fresnel;
    }
#endif
    (*lit).diffuse += diffuse * pbr.diffuse_occlusion;
    (*lit).specular += specular * pbr.specular_occlusion;
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    if transmits(point) {
        // Bevy takes the back for a surface that reflects everything, of a look-up value of 0.1: this remains of that.
        let back = LayerLightingInput(-(*point).N, -(*point).N, 1.0, 1.0, 1.0);
        let behind = compute_multiscatter(vec3(1.0), vec2(0.1), 1.0 - (0.1 + 0.1), 1.0);
        let light = compute_radiances(back, ranges, (*point).position, false).irradiance;
        (*lit).diffuse += (behind.FmsEms + behind.Edss) * light * (*point).transmitted_color;
    }
#endif
}
#endif

#ifdef STANDARD_MATERIAL_ANISOTROPY
#ifdef ENVIRONMENT_MAP
/// As Bevy's `bend_normal_for_anisotropy`, from the glTF extension `KHR_materials_anisotropy`.
fn bend(point: ptr<function, ShadingPoint>, layer: ptr<function, LayerLightingInput>) {
    let V = (*point).V;
    let bitangent = (*point).bitangent;
    let towards = normalize(cross(cross(bitangent, V), bitangent));
    let roughness = (*point).roughness;
    let a = exp2(exp2(1.0 - (*point).anisotropy * (1.0 - roughness)));
    let bent = normalize(mix(towards, (*point).N, a));
    (*layer).N = bent;
    (*layer).R = normalize(mix(reflect(-V, bent), bent, roughness * roughness));
}
#endif
#endif
