// Evaluates Bevy's lighting once more for direct light alone. Its functions for ambient light and environment maps are
// overridden: no occlusion of the surface would leave out what comes through it from behind.
#define_import_path bevy_lean_deferred::lighting::direct_light

#import bevy_pbr::ambient

#ifdef ENVIRONMENT_MAP
#import bevy_pbr::clustered_forward::ClusterableObjectIndexRanges
#import bevy_pbr::environment_map
#import bevy_pbr::environment_map::EnvironmentMapLight
#import bevy_pbr::lighting::LightingInput
#endif

var<private> only_direct_light: bool = false;

/// From here on, this invocation finds direct light only.
fn leave_others_out() {
    only_direct_light = true;
}

override fn ambient::ambient_light(
    world_position: vec4<f32>,
    world_normal: vec3<f32>,
    V: vec3<f32>,
    NdotV: f32,
    diffuse_color: vec3<f32>,
    specular_color: vec3<f32>,
    perceptual_roughness: f32,
    occlusion: vec3<f32>,
) -> vec3<f32> {
    if only_direct_light {
        return vec3(0.0);
    }
    return ambient::ambient_light(
        world_position,
        world_normal,
        V,
        NdotV,
        diffuse_color,
        specular_color,
        perceptual_roughness,
        occlusion,
    );
}

#ifdef ENVIRONMENT_MAP
override fn environment_map::environment_map_light(
    input: ptr<function, LightingInput>,
    clusterable_object_index_ranges: ptr<function, ClusterableObjectIndexRanges>,
    found_diffuse_indirect: bool,
) -> EnvironmentMapLight {
    if only_direct_light {
        return EnvironmentMapLight(vec3(0.0), vec3(0.0));
    }
    return environment_map::environment_map_light(
        input,
        clusterable_object_index_ranges,
        found_diffuse_indirect,
    );
}
#endif
