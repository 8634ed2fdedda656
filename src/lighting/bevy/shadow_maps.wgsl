// Visibility of lights in Bevy's shadow maps.
#define_import_path bevy_lean_deferred::lighting::bevy::shadow_maps

#import bevy_pbr::mesh_view_bindings as view_bindings
#import bevy_pbr::mesh_view_bindings::clustered_lights
#import bevy_pbr::shadow_sampling
#import bevy_pbr::shadows::{fetch_directional_shadow, fetch_point_shadow, fetch_spot_shadow}

#ifdef SUPERSET
#import bevy_lean_deferred::lighting::parts

// Like Bevy's, which are compiled for one filter, with the view's.

override fn shadow_sampling::sample_shadow_map(
    light_local: vec2<f32>,
    depth: f32,
    array_index: i32,
    frag_coord_xy: vec2<f32>,
    texel_size: f32,
) -> f32 {
    if parts::has(parts::GAUSSIAN_SHADOWS) {
        return shadow_sampling::sample_shadow_map_castano_thirteen(light_local, depth, array_index);
    }
    if parts::has(parts::TEMPORAL_SHADOWS) {
        return shadow_sampling::sample_shadow_map_jimenez_fourteen(
            light_local, depth, array_index, frag_coord_xy, texel_size, 1.0, true);
    }
    return shadow_sampling::sample_shadow_map_hardware(light_local, depth, array_index);
}

override fn shadow_sampling::sample_shadow_cubemap(
    light_local: vec3<f32>,
    distance_to_light: f32,
    depth: f32,
    light_id: u32,
    frag_coord_xy: vec2<f32>,
) -> f32 {
    if parts::has(parts::GAUSSIAN_SHADOWS) {
        return shadow_sampling::sample_shadow_cubemap_gaussian(
            light_local, depth, shadow_sampling::POINT_SHADOW_SCALE, distance_to_light, light_id);
    }
    if parts::has(parts::TEMPORAL_SHADOWS) {
        return shadow_sampling::sample_shadow_cubemap_jittered(
            light_local, depth, frag_coord_xy, shadow_sampling::POINT_SHADOW_SCALE, distance_to_light, light_id, true);
    }
    return shadow_sampling::sample_shadow_cubemap_hardware(light_local, depth, light_id);
}
#endif

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

#ifdef SUPERSET
override fn shadow_sampling::sample_shadow_map_pcss(
    light_local: vec2<f32>,
    depth: f32,
    array_index: i32,
    frag_coord_xy: vec2<f32>,
    texel_size: f32,
    light_size: f32,
) -> f32 {
    let z_blocker = shadow_sampling::search_for_blockers_in_shadow_map(
        light_local, depth, array_index, texel_size, light_size);
    let blur_size = max((z_blocker - depth) * light_size / depth, 0.5);
    return shadow_sampling::sample_shadow_map_jimenez_fourteen(
        light_local, depth, array_index, frag_coord_xy, texel_size, blur_size, parts::has(parts::TEMPORAL_SHADOWS));
}

override fn shadow_sampling::sample_shadow_cubemap_pcss(
    light_local: vec3<f32>,
    distance_to_light: f32,
    depth: f32,
    light_id: u32,
    light_size: f32,
    frag_coord_xy: vec2<f32>,
) -> f32 {
    let z_blocker = shadow_sampling::search_for_blockers_in_shadow_cubemap(
        light_local, depth, light_size, distance_to_light, light_id);
    let blur_size = max((z_blocker - depth) * light_size / depth, 0.5);
    return shadow_sampling::sample_shadow_cubemap_jittered(
        light_local,
        depth,
        frag_coord_xy,
        shadow_sampling::POINT_SHADOW_SCALE * blur_size,
        distance_to_light,
        light_id,
        parts::has(parts::TEMPORAL_SHADOWS),
    );
}
#endif   // SUPERSET
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
