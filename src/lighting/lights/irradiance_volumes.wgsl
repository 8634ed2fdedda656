// Light of irradiance volumes.
#define_import_path bevy_lean_deferred::lighting::lights::irradiance_volumes

#ifdef IRRADIANCE_VOLUME
#import bevy_lean_deferred::lighting::lights::light_probe::weight_in_probe
#import bevy_pbr::{
    clustered_forward::{ClusterableObjectIndexRanges, get_clusterable_object_id},
    mesh_view_bindings::{irradiance_volume_sampler, light_probes},
}

#ifdef MULTIPLE_LIGHT_PROBES_IN_ARRAY
#import bevy_pbr::mesh_view_bindings::irradiance_volumes
#else
#import bevy_pbr::mesh_view_bindings::irradiance_volume
#endif

#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::light_layers::irradiance_volume_affects_mesh
#endif

/// Mean radiance around `normal`: like Bevy's `irradiance_volume_light`, whose iterator keeps a whole probe in registers.
fn irradiance_of_volumes(
    position: vec3<f32>,
    normal: vec3<f32>,
    ranges: ptr<function, ClusterableObjectIndexRanges>,
) -> vec3<f32> {
    var sum = vec3(0.0);
    var weights = 0.0;
    let end = (*ranges).first_decal_offset;
    for (var i = (*ranges).first_irradiance_volume_index_offset; i < end; i++) {
        let id = i32(get_clusterable_object_id(i));
        // Its image is not loaded yet.
        if id < 0 {
            continue;
        }
#ifdef LIGHT_LAYERS
        if !irradiance_volume_affects_mesh(u32(id)) {
            continue;
        }
#endif
        let place = vec4(position, 1.0) * light_probes.irradiance_volumes[id].light_from_world_transposed;
        let weight = weight_in_probe(place, light_probes.irradiance_volumes[id].falloff);
        if weight == 0.0 {
            continue;
        }
        let scale = weight * light_probes.irradiance_volumes[id].intensity;
        sum += scale * irradiance_in_volume(light_probes.irradiance_volumes[id].cubemap_index, place, normal);
        weights += weight;
    }
    if weights != 0.0 {
        sum /= weights;
    }
    return sum;
}

/// Mean radiance around `normal` at `place` in a volume: an ambient cube (Mitchell, McTaggart and Green 2006, "Shading in Valve's Source
/// Engine"), of which the volume's image has the faces of each axis above each other, those of negative directions below.
fn irradiance_in_volume(volume: i32, place: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
#ifdef MULTIPLE_LIGHT_PROBES_IN_ARRAY
    let size = textureDimensions(irradiance_volumes[volume]);
#else
    let size = textureDimensions(irradiance_volume);
#endif
    let voxels = vec3<f32>(size / vec3(1u, 2u, 3u));
    // Stays within the outer voxels' centres: beyond are those of another face.
    let uvw = clamp((place + 0.5) * voxels, vec3(0.5), voxels - 0.5) / vec3<f32>(size);
    let lower = select(vec3(0.0), vec3(0.5), normal < vec3(0.0));
    let squares = normal * normal;
    var irradiance = vec3(0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        let face = uvw + vec3(0.0, lower[axis], f32(axis) / 3.0);
#ifdef MULTIPLE_LIGHT_PROBES_IN_ARRAY
        let radiance = textureSampleLevel(irradiance_volumes[volume], irradiance_volume_sampler, face, 0.0).rgb;
#else
        let radiance = textureSampleLevel(irradiance_volume, irradiance_volume_sampler, face, 0.0).rgb;
#endif
        irradiance += squares[axis] * radiance;
    }
    return irradiance;
}
#endif  // IRRADIANCE_VOLUME
