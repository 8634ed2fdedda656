// Indirect light in Bevy's order: lightmaps, irradiance volumes, environment maps with reflection probes, ambient light. The
// first source of diffuse light excludes all later ones but ambient light. Reflections and diffuse GI replace the part of this
// light that they cover, so that none is counted twice and none is lost.
#define_import_path bevy_lean_deferred::lighting::lights::indirect_light

#import bevy_lean_deferred::lighting::lights::screen_space_light::ScreenSpaceLight
#import bevy_lean_deferred::lighting::lights::lit::Lit
#import bevy_lean_deferred::lighting::lights::shading_point::{ShadingPoint, view_cosine}
#import bevy_lean_deferred::lighting::parts
#import bevy_pbr::{
    clustered_forward::{ClusterableObjectIndexRanges, unpack_clusterable_object_index_ranges},
    lighting::{EnvBRDFApprox, F_AB},
    mesh_view_bindings::{light_probes, lights},
    pbr_types::PbrInput,
}

#ifdef ENVIRONMENT_MAP
#import bevy_lean_deferred::lighting::lights::environment::radiances_of
#import bevy_pbr::lighting::LayerLightingInput
#endif

#ifdef IRRADIANCE_VOLUME
#import bevy_lean_deferred::lighting::lights::irradiance_volumes::irradiance_of_volumes
#endif

#ifdef STANDARD_MATERIAL_ANISOTROPY
#import bevy_lean_deferred::lighting::lights::brdf::unit
#import bevy_lean_deferred::lighting::lights::shading_point::bitangent_at
#endif

#ifdef STANDARD_MATERIAL_CLEARCOAT
#import bevy_lean_deferred::lighting::lights::shading_point::view_fresnel
#endif

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#import bevy_lean_deferred::lighting::lights::shading_point::transmits
#endif

/// Light of light probes and environment maps.
struct Surroundings {
    /// Mean radiance around the normal: of irradiance volumes, or else of environment maps. 0 where a lightmap has it.
    irradiance: vec3<f32>,
    /// Radiance from about the mirrored direction.
    radiance: vec3<f32>,
    /// Light that only one shading model needs: radiance in the coat's mirror, mean radiance at the back, or that along the eye's ray
    /// from behind, for rim light.
    of_model: vec3<f32>,
}

/// Light of light probes and environment maps at `point`, of which it reads positions, directions, both roughnesses and the shading
/// model. `cluster` is the pixel's.
fn surroundings_of(point: ptr<function, ShadingPoint>, cluster: u32) -> Surroundings {
    var around: Surroundings;
    var ranges = unpack_clusterable_object_index_ranges(cluster);
    var found_diffuse = false;
#ifdef LIGHTMAPPED_SURFACES
    found_diffuse = (*point).is_lightmapped;
#endif
#ifdef IRRADIANCE_VOLUME
    if !found_diffuse && parts::has(parts::IRRADIANCE_VOLUME) {
        around.irradiance = irradiance_of_volumes((*point).position, (*point).N, &ranges);
#ifdef SHADING_MODEL_RIM
        if (*point).has_rim_light {
            around.of_model = irradiance_of_volumes((*point).position, -(*point).V, &ranges);
        }
#endif
        found_diffuse = true;
    }
#endif
#ifdef ENVIRONMENT_MAP
    if parts::has(parts::ENVIRONMENT_MAP) {
        add_environment_maps(point, &ranges, found_diffuse, &around);
    }
#endif
    return around;
}

#ifdef ENVIRONMENT_MAP
fn add_environment_maps(
    point: ptr<function, ShadingPoint>,
    ranges: ptr<function, ClusterableObjectIndexRanges>,
    found_diffuse: bool,
    around: ptr<function, Surroundings>,
) {
    let has_second = has_second_layer(point, found_diffuse);
    // One call for both layers, since its code is long.
    for (var is_base = true; ; is_base = false) {
        let skips_irradiance = select(skips_irradiance_of_model(point), found_diffuse, is_base);
        let radiances = radiances_of(layer_of(point, is_base), ranges, (*point).position, skips_irradiance);
        if is_base {
            (*around).radiance = radiances.radiance;
            if !found_diffuse {
                (*around).irradiance = radiances.irradiance;
            }
        } else {
            (*around).of_model = radiances.irradiance;
#ifdef STANDARD_MATERIAL_CLEARCOAT
            if (*point).clearcoat > 0.0 {
                (*around).of_model = radiances.radiance;
            }
#endif
        }
        if !is_base || !has_second {
            break;
        }
    }
}

/// True if the surface has a coat, transmits light, or has rim light that is not found yet.
fn has_second_layer(point: ptr<function, ShadingPoint>, found_diffuse: bool) -> bool {
#ifdef STANDARD_MATERIAL_CLEARCOAT
    if (*point).clearcoat > 0.0 {
        return true;
    }
#endif
#ifdef SHADING_MODEL_RIM
    if (*point).has_rim_light {
        return !found_diffuse;
    }
#endif
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    return transmits(point);
#else
    return false;
#endif
}

/// True if the shading model does not need the irradiance of its layer.
fn skips_irradiance_of_model(point: ptr<function, ShadingPoint>) -> bool {
#ifdef STANDARD_MATERIAL_CLEARCOAT
    if (*point).clearcoat > 0.0 {
        return true;
    }
#endif
#ifdef LIGHTMAPPED_SURFACES
    // Bevy asks each probe whether it affects lightmapped surfaces; here the view's map decides for all of them.
    return (*point).is_lightmapped && light_probes.view_environment_map_affects_lightmapped_mesh_diffuse == 0u;
#else
    return false;
#endif
}

/// The base's layer, or that of the shading model: the coat, the ray from behind for rim light, or the back.
fn layer_of(point: ptr<function, ShadingPoint>, is_base: bool) -> LayerLightingInput {
    let N = (*point).N;
    var layer = LayerLightingInput(
        N, reflect(-(*point).V, N), view_cosine(point), (*point).perceptual_roughness, (*point).roughness,
    );
    if is_base {
#ifdef STANDARD_MATERIAL_ANISOTROPY
        if (*point).is_anisotropic {
            bend(point, &layer);
        }
#endif
        return layer;
    }
#ifdef STANDARD_MATERIAL_CLEARCOAT
    if (*point).clearcoat > 0.0 {
        layer.perceptual_roughness = (*point).clearcoat_perceptual_roughness;
        layer.roughness = (*point).clearcoat_roughness;
        return layer;
    }
#endif
    var behind = -N;
#ifdef SHADING_MODEL_RIM
    if (*point).has_rim_light {
        behind = -(*point).V;
    }
#endif
    return LayerLightingInput(behind, behind, 1.0, 1.0, 1.0);
}
#endif

/// Adds indirect light, occluded by `pbr`. Light in `found` is occluded by the material alone.
fn add_indirect_light(
    point: ptr<function, ShadingPoint>,
    pbr: PbrInput,
    around: Surroundings,
    found: ScreenSpaceLight,
    lit: ptr<function, Lit>,
) {
    var is_lightmapped = false;
#ifdef LIGHTMAPPED_SURFACES
    is_lightmapped = (*point).is_lightmapped;
    if is_lightmapped {
        (*lit).diffuse += pbr.lightmap_light * (*point).diffuse_color;
    }
#endif
    var of_maps = around;
#ifdef IRRADIANCE_VOLUME
    if parts::has(parts::IRRADIANCE_VOLUME) {
        (*lit).diffuse += around.irradiance * (*point).diffuse_color * pbr.diffuse_occlusion;
        of_maps.irradiance = vec3(0.0);
    }
#endif
#ifdef ENVIRONMENT_MAP
    if parts::has(parts::ENVIRONMENT_MAP) {
        add_environment(point, pbr, of_maps, found.confidence, lit);
    }
#endif
    // The same for all pixels: most scenes with an environment map have no ambient light.
    if any(lights.ambient_color.rgb != vec3(0.0)) {
        if !is_lightmapped || lights.ambient_light_affects_lightmapped_meshes != 0u {
            add_ambient_light(point, pbr, found.confidence, lit);
        }
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
        add_transmitted_ambient_light(point, lit);
#endif
    }
#ifdef INDIRECT_LIGHT
    if parts::has(parts::INDIRECT_SPECULAR | parts::INDIRECT_DIFFUSE) {
        add_screen_space_light(point, pbr.specular_occlusion, found, is_lightmapped, lit);
    }
#endif
}

/// Share of the environment available to specular reflection, of which occlusion leaves `visible`. With reflections, the smoother
/// the surface, the more its own rays decide visibility.
fn mirrorable(visible: vec3<f32>, perceptual_roughness: f32) -> vec3<f32> {
#ifdef INDIRECT_SPECULAR
    if parts::has(parts::INDIRECT_SPECULAR) {
        return mix(vec3(1.0), visible, perceptual_roughness);
    }
#endif
    return visible;
}

/// `mirrorable`, beside a reflection with `confidence`: that reflection counts as the first occluder of the environment.
fn unhidden(visible: vec3<f32>, perceptual_roughness: f32, confidence: f32) -> vec3<f32> {
    return min(mirrorable(visible, perceptual_roughness), vec3(1.0 - confidence));
}

/// Like Bevy's `ambient_light`.
fn add_ambient_light(
    point: ptr<function, ShadingPoint>,
    pbr: PbrInput,
    confidence: f32,
    lit: ptr<function, Lit>,
) {
    let occlusion = pbr.diffuse_occlusion;
    var visible = occlusion;
#ifdef INDIRECT_DIFFUSE
    if parts::has(parts::INDIRECT_DIFFUSE) {
        // As for environment maps: the light of its occluders is in `ScreenSpaceLight`.
        visible = vec3(pbr.specular_occlusion);
    }
#endif
    let color = lights.ambient_color.rgb;
    let diffuse = EnvBRDFApprox((*point).diffuse_color, F_AB(1.0, (*point).NdotV));
    let specular = EnvBRDFApprox((*point).F_normal, (*point).F_ab) * (*point).F_grazing;
    (*lit).diffuse += diffuse * color * occlusion;
    (*lit).specular += specular * color * unhidden(visible, (*point).perceptual_roughness, confidence);
}

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
/// Like Bevy's `ambient_light` for the back. Lightmaps do not contain it.
fn add_transmitted_ambient_light(point: ptr<function, ShadingPoint>, lit: ptr<function, Lit>) {
    if transmits(point) {
        (*lit).diffuse += EnvBRDFApprox((*point).transmitted_color, F_AB(1.0, 1.0)) * lights.ambient_color.rgb;
    }
}
#endif

/// Response of the surface to environment light, as factors of it.
struct EnvironmentResponse {
    /// Factor of the mean radiance.
    diffuse: vec3<f32>,
    /// Factor of the radiance from the mirrored direction.
    specular: vec3<f32>,
}

/// As in Bevy's `environment_map_light` (Fdez-Agüera 2019, "A Multiple-Scattering Microfacet Model for Real-Time
/// Image-Based Lighting").
fn environment_response(point: ptr<function, ShadingPoint>) -> EnvironmentResponse {
    let dielectric = scattered(point, (*point).F0_dielectric);
    let metallic = scattered(point, (*point).F0_metallic);
    let transmitted = 1.0 - (dielectric.once + dielectric.again);
    return EnvironmentResponse(
        mix(dielectric.again, metallic.again, (*point).metallic) + (*point).diffuse_color * transmitted,
        mix(dielectric.once, metallic.once, (*point).metallic),
    );
}

/// Light reflected by microfacets of one reflectance, after single and multiple scattering.
struct Scattered {
    once: vec3<f32>,
    again: vec3<f32>,
}

fn scattered(point: ptr<function, ShadingPoint>, F0: vec3<f32>) -> Scattered {
    let F_ab = (*point).F_ab;
    let missing = 1.0 - (F_ab.x + F_ab.y);
    let once = (F0 * F_ab.x + F_ab.y) * (*point).F_grazing;
    let mean = F0 + (1.0 - F0) / 21.0;
    return Scattered(once, once * mean / (1.0 - missing * mean) * missing);
}

#ifdef STANDARD_MATERIAL_CLEARCOAT
/// Share of mirrored light that the coat reflects.
fn coat_fresnel(point: ptr<function, ShadingPoint>) -> f32 {
    return (0.04 + 0.96 * view_fresnel(point)) * (*point).clearcoat;
}
#endif

#ifdef INDIRECT_LIGHT
/// Adds the light of other effects. Lightmaps have the diffuse part already. The environment is `visible` in the mirrored
/// direction; occluders without a reflection get the mean radiance of the surfaces around.
fn add_screen_space_light(
    point: ptr<function, ShadingPoint>,
    visible: f32,
    found: ScreenSpaceLight,
    is_lightmapped: bool,
    lit: ptr<function, Lit>,
) {
    let response = environment_response(point);
    var roughness = (*point).perceptual_roughness;
    var diffuse = response.diffuse * found.irradiance * found.material_visibility;
    var specular = response.specular;
    // Factor of the base beneath a coat: only the coat has reflections.
    var below = vec3(0.0);
#ifdef STANDARD_MATERIAL_CLEARCOAT
    if (*point).clearcoat > 0.0 {
        let fresnel = coat_fresnel(point);
        let passed = 1.0 - fresnel;
        roughness = (*point).clearcoat_perceptual_roughness;
        diffuse *= passed;
        specular = vec3(fresnel);
        below = response.specular * (passed * passed * (1.0 - visible));
    }
#endif
    let hidden = 1.0 - found.confidence - unhidden(vec3(visible), roughness, found.confidence).x;
    let around = found.irradiance / max(1.0 - found.visibility, 1e-3);
    if !is_lightmapped {
        (*lit).diffuse += diffuse;
    }
    (*lit).specular += specular * found.radiance * found.confidence + (specular * hidden + below) * around;
}
#endif

#ifdef ENVIRONMENT_MAP
/// Like Bevy's `environment_map_light`. `confidence` is that of the reflection that replaces the environment.
fn add_environment(
    point: ptr<function, ShadingPoint>,
    pbr: PbrInput,
    around: Surroundings,
    confidence: f32,
    lit: ptr<function, Lit>,
) {
    let response = environment_response(point);
    var diffuse = response.diffuse * around.irradiance;
    var specular = response.specular * around.radiance;
    let visible = vec3(pbr.specular_occlusion);
#ifdef STANDARD_MATERIAL_CLEARCOAT
    if (*point).clearcoat > 0.0 {
        let fresnel = coat_fresnel(point);
        let passed = 1.0 - fresnel;
        diffuse *= passed;
        specular = specular * (passed * passed) * visible
            + around.of_model * fresnel * unhidden(visible, (*point).clearcoat_perceptual_roughness, confidence);
    } else {
        specular *= unhidden(visible, (*point).perceptual_roughness, confidence);
    }
#else
    specular *= unhidden(visible, (*point).perceptual_roughness, confidence);
#endif
    (*lit).diffuse += diffuse * pbr.diffuse_occlusion;
    (*lit).specular += specular;
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    if transmits(point) {
        // Share that Bevy counts as not reflected there, with a look-up value of 0.1.
        let transmitted = 1.0 - (0.1 + 0.1);
        (*lit).diffuse += transmitted * around.of_model * (*point).transmitted_color;
    }
#endif
}
#endif

#ifdef STANDARD_MATERIAL_ANISOTROPY
#ifdef ENVIRONMENT_MAP
/// Like Bevy's `bend_normal_for_anisotropy`, from the glTF extension `KHR_materials_anisotropy`.
fn bend(point: ptr<function, ShadingPoint>, layer: ptr<function, LayerLightingInput>) {
    let V = (*point).V;
    let bitangent = bitangent_at(point);
    let towards = unit(cross(cross(bitangent, V), bitangent));
    let roughness = (*point).roughness;
    let a = exp2(exp2(1.0 - (*point).anisotropy * (1.0 - roughness)));
    let bent = normalize(mix(towards, (*point).N, a));
    (*layer).N = bent;
    (*layer).R = normalize(mix(reflect(-V, bent), bent, roughness * roughness));
}
#endif
#endif
