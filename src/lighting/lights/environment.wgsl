// Light of environment maps: of reflection probes and of the view.
#define_import_path bevy_lean_deferred::lighting::lights::environment

#ifdef ENVIRONMENT_MAP
#ifdef MULTIPLE_LIGHT_PROBES_IN_ARRAY
#import bevy_lean_deferred::lighting::lights::light_probe::weight_in_probe
#import bevy_pbr::{
    clustered_forward::{ClusterableObjectIndexRanges, get_clusterable_object_id},
    environment_map::{EnvironmentMapRadiances, FLOAT_MAX, quat_rotate, radiance_sample_direction},
    lighting::LayerLightingInput,
    mesh_view_bindings::{diffuse_environment_maps, environment_map_sampler, light_probes, specular_environment_maps},
    mesh_view_types::{LIGHT_PROBE_FLAG_AFFECTS_LIGHTMAPPED_MESH_DIFFUSE, LIGHT_PROBE_FLAG_PARALLAX_CORRECT},
}
#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::light_layers::reflection_probe_affects_mesh
#endif

/// Like Bevy's `compute_radiances`, whose iterator keeps two whole probes in registers.
fn radiances_of(
    layer: LayerLightingInput,
    ranges: ptr<function, ClusterableObjectIndexRanges>,
    position: vec3<f32>,
    found_diffuse: bool,
) -> EnvironmentMapRadiances {
    let towards = radiance_sample_direction(layer.N, layer.R, layer.roughness);
    var sum: EnvironmentMapRadiances;
    var weights = 0.0;
    let end = (*ranges).first_irradiance_volume_index_offset;
    for (var i = (*ranges).first_reflection_probe_index_offset; i < end; i++) {
        let id = i32(get_clusterable_object_id(i));
        // Its images are not loaded yet.
        if id < 0 {
            continue;
        }
#ifdef LIGHT_LAYERS
        if !reflection_probe_affects_mesh(u32(id)) {
            continue;
        }
#endif
        let into_probe = light_probes.reflection_probes[id].light_from_world_transposed;
        let place = vec4(position, 1.0) * into_probe;
        let weight = weight_in_probe(place, light_probes.reflection_probes[id].falloff);
        if weight == 0.0 {
            continue;
        }
        // All directions here: the matrix takes twelve registers.
        let normal = vec4(layer.N, 0.0) * into_probe;
        let mirrored = vec4(towards, 0.0) * into_probe;
        let bounds = light_probes.reflection_probes[id].parallax_correction_bounds;
        let has_parallax = (light_probes.reflection_probes[id].flags & LIGHT_PROBE_FLAG_PARALLAX_CORRECT) != 0u;
        var adds_diffuse = !found_diffuse;
#ifdef LIGHTMAP
        adds_diffuse = adds_diffuse
            && (light_probes.reflection_probes[id].flags & LIGHT_PROBE_FLAG_AFFECTS_LIGHTMAPPED_MESH_DIFFUSE) != 0u;
#endif
        let map = light_probes.reflection_probes[id].cubemap_index;
        let scale = weight * light_probes.reflection_probes[id].intensity;
        if adds_diffuse {
            sum.irradiance += scale * irradiance_from(map, seen_in_probe(place, normal, bounds, has_parallax));
        }
        let seen = seen_in_probe(place, mirrored, bounds, has_parallax);
        sum.radiance += scale * radiance_from(map, seen, layer.perceptual_roughness);
        weights += weight;
    }
    // The view's map has the rest of the weight.
    let map = light_probes.view_cubemap_index;
    if weights < 0.9999 && map >= 0 {
        let scale = (1.0 - weights) * light_probes.intensity_for_view;
        var adds_diffuse = !found_diffuse;
#ifdef LIGHTMAP
        adds_diffuse = adds_diffuse && light_probes.view_environment_map_affects_lightmapped_mesh_diffuse != 0u;
#endif
        if adds_diffuse {
            sum.irradiance += scale * irradiance_from(map, quat_rotate(light_probes.view_rotation, layer.N));
        }
        let seen = quat_rotate(light_probes.view_rotation, towards);
        sum.radiance += scale * radiance_from(map, seen, layer.perceptual_roughness);
        weights = 1.0;
    }
    if weights != 0.0 {
        sum.irradiance /= weights;
        sum.radiance /= weights;
    }
    return sum;
}

/// Direction of what a probe's map shows from `place` towards `direction`: for parallax, of where the ray leaves the box.
fn seen_in_probe(place: vec3<f32>, direction: vec3<f32>, bounds: vec3<f32>, has_parallax: bool) -> vec3<f32> {
    if !has_parallax {
        return direction;
    }
    let low = (-bounds - place) / direction;
    let high = (bounds - place) / direction;
    let ahead = min(select(vec3(FLOAT_MAX), low, low >= vec3(0.0)), select(vec3(FLOAT_MAX), high, high >= vec3(0.0)));
    return place + direction * min(min(ahead.x, ahead.y), ahead.z);
}

/// Mean radiance around `direction` in a map.
fn irradiance_from(map: i32, direction: vec3<f32>) -> vec3<f32> {
    // Cube maps are left-handed.
    let sampled = direction * vec3(1.0, 1.0, -1.0);
    return textureSampleLevel(diffuse_environment_maps[map], environment_map_sampler, sampled, 0.0).rgb;
}

/// Radiance from about `direction` in a map.
fn radiance_from(map: i32, direction: vec3<f32>, perceptual_roughness: f32) -> vec3<f32> {
    let sampled = direction * vec3(1.0, 1.0, -1.0);
    let level = perceptual_roughness * f32(textureNumLevels(specular_environment_maps[map]) - 1u);
    return textureSampleLevel(specular_environment_maps[map], environment_map_sampler, sampled, level).rgb;
}
#else
#import bevy_pbr::{
    clustered_forward::ClusterableObjectIndexRanges,
    environment_map::{EnvironmentMapRadiances, compute_radiances},
    lighting::LayerLightingInput,
}

/// Bevy's, of the view's map.
fn radiances_of(
    layer: LayerLightingInput,
    ranges: ptr<function, ClusterableObjectIndexRanges>,
    position: vec3<f32>,
    found_diffuse: bool,
) -> EnvironmentMapRadiances {
    return compute_radiances(layer, ranges, position, found_diffuse);
}
#endif  // MULTIPLE_LIGHT_PROBES_IN_ARRAY
#endif  // ENVIRONMENT_MAP
