// Visibility of lights in Bevy's shadow maps.
#define_import_path bevy_lean_deferred::lighting::bevy::shadow_maps

#import bevy_pbr::mesh_view_bindings as view_bindings
#import bevy_pbr::mesh_view_bindings::clustered_lights
#import bevy_pbr::shadow_sampling
#import bevy_pbr::shadows::{fetch_directional_shadow, fetch_point_shadow, fetch_spot_shadow}

#ifdef SOFT_SHADOWS
/// Like Bevy's, with an explicit mip: derivatives exist in fragment shaders only, and shadow maps have one mip.
override fn shadow_sampling::search_for_blockers_in_shadow_cubemap_hardware(
    light_local: vec3<f32>,
    depth: f32,
    light_id: u32,
) -> vec2<f32> {
#ifdef PCSS_SAMPLERS_AVAILABLE
#ifdef NO_CUBE_ARRAY_TEXTURES_SUPPORT
    let sampled_depth = textureSampleLevel(
        view_bindings::point_shadow_textures,
        view_bindings::point_shadow_textures_linear_sampler,
        light_local,
        0u,
    );
#else
    let sampled_depth = textureSampleLevel(
        view_bindings::point_shadow_textures,
        view_bindings::point_shadow_textures_linear_sampler,
        light_local,
        i32(light_id),
        0u,
    );
#endif
    return select(vec2(0.0), vec2(sampled_depth, 1.0), sampled_depth >= depth);
#else
    return vec2(0.0);
#endif
}
#else   // SOFT_SHADOWS
// No light has percentage-closer soft shadows, so their filters are compiled out.

override fn shadow_sampling::sample_shadow_map_pcss(
    light_local: vec2<f32>,
    depth: f32,
    array_index: i32,
    frag_coord_xy: vec2<f32>,
    texel_size: f32,
    light_size: f32,
) -> f32 {
    return 1.0;
}

override fn shadow_sampling::sample_shadow_cubemap_pcss(
    light_local: vec3<f32>,
    distance_to_light: f32,
    depth: f32,
    light_id: u32,
    light_size: f32,
    frag_coord_xy: vec2<f32>,
) -> f32 {
    return 1.0;
}
#endif  // SOFT_SHADOWS

/// Visibility of the directional light with this index.
fn directional_shadow(id: u32, position: vec3<f32>, normal: vec3<f32>, view_z: f32, pixel: vec2<i32>) -> f32 {
    return fetch_directional_shadow(id, vec4(position, 1.0), normal, view_z, vec2<f32>(pixel) + 0.5);
}

/// Visibility of the point or spot light with this index.
fn clustered_shadow(id: u32, is_spot: bool, position: vec3<f32>, normal: vec3<f32>, pixel: vec2<i32>) -> f32 {
    let coordinates = vec2<f32>(pixel) + 0.5;
    if is_spot {
#ifdef SPOT_SHADOW_MAPS
        let near = clustered_lights.data[id].shadow_map_near_z;
        return fetch_spot_shadow(id, vec4(position, 1.0), normal, near, coordinates);
#endif
    } else {
#ifdef POINT_SHADOW_MAPS
        return fetch_point_shadow(id, vec4(position, 1.0), normal, coordinates);
#endif
    }
    return 1.0;
}
