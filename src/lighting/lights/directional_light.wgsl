// Light from all directional lights, like Bevy's `directional_light`.
#define_import_path bevy_lean_deferred::lighting::lights::directional_light

#import bevy_lean_deferred::lighting::lights::brdf::{LightAccumulator, accumulate, response}
#import bevy_lean_deferred::lighting::lights::shading_point::ShadingPoint
#import bevy_lean_deferred::lighting::parts
#import bevy_pbr::mesh_view_bindings as view_bindings
#import bevy_pbr::mesh_view_types

#ifdef ATMOSPHERE
#import bevy_pbr::atmosphere::functions::{calculate_visible_sun_ratio, clamp_to_surface}
#import bevy_pbr::lighting::sample_transmittance_lut
#endif

#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::light_layers::directional_light_affects_mesh
#endif

#ifdef DIRECTIONAL_SHADOW_MAPS
#import bevy_lean_deferred::lighting::bevy::shadow_maps::directional_shadow
#import bevy_lean_deferred::lighting::lights::shading_point::geometric_normal
#ifndef FORWARD_MESH
#import bevy_lean_deferred::gbuffer::layout::{unpack_has_mesh_normal, unpack_normal}
#import bevy_lean_deferred::lighting::surface::{Pixel, position_at, shadow_normal}
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#import bevy_lean_deferred::lighting::surface::{back_receives_shadows, thickness_of}
#endif
#ifdef CLUSTERED_DECALS_ARE_USABLE
#import bevy_pbr::clustered_forward::{
    unpack_clusterable_object_index_ranges, view_fragment_cluster_index,
}
#import bevy_pbr::decal::clustered::{clustered_decal_iterator_new, clustered_decal_iterator_next}
#endif
#endif
#endif

#ifdef CONTACT_SHADOWS
#import bevy_lean_deferred::lighting::bevy::contact_shadow::contact_shadow
#endif

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#import bevy_lean_deferred::lighting::lights::brdf::response_from_behind
#import bevy_lean_deferred::lighting::lights::shading_point::{back_position, transmits}
#endif

/// Colour of the light at `position`, after its texture and the atmosphere.
fn color_at(id: u32, position: vec3<f32>) -> vec3<f32> {
    let light = &view_bindings::lights.directional_lights[id];
    var color = (*light).color.rgb;
#ifdef LIGHT_TEXTURES
    if (*light).decal_index != 0xffffffffu {
        let decal = &view_bindings::clustered_decals.decals[(*light).decal_index];
        let local = ((*decal).local_from_world * vec4(position, 1.0)).xyz;
        let uv = local.xy * vec2(-0.5, 0.5) + 0.5;
        let is_tiled = (*decal).tag != 0u;
        if !is_tiled && any(saturate(uv) != uv) {
            return vec3(0.0);
        }
        color *= textureSampleLevel(
            view_bindings::clustered_decal_textures[(*decal).base_color_texture_index],
            view_bindings::clustered_decal_sampler,
            uv - floor(uv),
            0.0,
        ).r;
    }
#endif
#ifdef ATMOSPHERE
    if parts::has(parts::ATMOSPHERE) {
        let atmosphere = view_bindings::atmosphere;
        let place = clamp_to_surface(atmosphere, (atmosphere.world_to_atmosphere * vec4(position, 1.0)).xyz);
        let r = length(place);
        // Clamp: Bevy's functions take roots of 1 - mu.
        let mu = clamp(dot((*light).direction_to_light, normalize(place)), -1.0, 1.0);
        color *= sample_transmittance_lut(r, mu)
            * calculate_visible_sun_ratio(atmosphere, r, mu, (*light).sun_disk_angular_size);
    }
#endif
    return color;
}

#ifdef DIRECTIONAL_SHADOW_MAPS
fn has_shadow_map(id: u32) -> bool {
    let flags = view_bindings::lights.directional_lights[id].flags;
    return (flags & mesh_view_types::DIRECTIONAL_LIGHT_FLAGS_SHADOWS_ENABLED_BIT) != 0u;
}
#endif

/// Visibility of directional lights in their shadow maps. Unused by meshes of Bevy's passes.
struct DirectionalShadows {
#ifdef SEVERAL_DIRECTIONAL_SHADOW_MAPS
    /// By the light's index.
    visibility: array<f32, #{MAX_DIRECTIONAL_LIGHTS}>,
#else
    /// Of the one light that has a shadow map: an array that is indexed at run time takes a register for each of its elements, or
    /// scratch memory.
    visibility: f32,
#endif
}

#ifdef DIRECTIONAL_SHADOW_MAPS
#ifndef FORWARD_MESH
fn set_visibility(shadows: ptr<function, DirectionalShadows>, id: u32, visibility: f32) {
#ifdef SEVERAL_DIRECTIONAL_SHADOW_MAPS
    (*shadows).visibility[id] = visibility;
#else
    (*shadows).visibility = visibility;
#endif
}

/// Visibility of the light with this index, 1 without a shadow map.
fn visibility_of(shadows: ptr<function, DirectionalShadows>, id: u32) -> f32 {
    if !has_shadow_map(id) {
        return 1.0;
    }
#ifdef SEVERAL_DIRECTIONAL_SHADOW_MAPS
    return (*shadows).visibility[id];
#else
    return (*shadows).visibility;
#endif
}

/// Must be called before other terms of the surface are computed: sampling takes many registers, so that little else should be
/// live. Shadow maps of lights that cannot reach the surface are not sampled. Those of lights behind a surface that transmits light
/// are sampled at its back.
fn find_directional_shadows(pixel: Pixel, shadows: ptr<function, DirectionalShadows>) {
    let in_view = position_at(pixel.position, pixel.depth);
    let position = (view_bindings::view.world_from_view * vec4(in_view, 1.0)).xyz;
    let N = unpack_normal(pixel.normal_word);
    var normal = N;
    var knows_normal = unpack_has_mesh_normal(pixel.surface_word);
#ifdef CLUSTERED_DECALS_ARE_USABLE
    var knows_decals = false;
    var may_turn = false;
#endif
    let count = view_bindings::lights.n_directional_lights;
    for (var id = 0u; id < count; id++) {
        if !has_shadow_map(id) {
            continue;
        }
        set_visibility(shadows, id, 1.0);
#ifdef LIGHT_LAYERS
        if !directional_light_affects_mesh(id) {
            continue;
        }
#endif
        let L = view_bindings::lights.directional_lights[id].direction_to_light;
        var is_before = dot(N, L) > 0.0;
#ifdef CLUSTERED_DECALS_ARE_USABLE
        if !is_before && !knows_decals {
            may_turn = decals_may_turn_normal(pixel.position, position, in_view.z);
            knows_decals = true;
        }
        is_before = is_before || may_turn;
#endif
        var is_behind = false;
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#ifndef CLUSTERED_DECALS_ARE_USABLE
        is_behind = dot(N, L) < 0.0 && back_receives_shadows(pixel);
#endif
#endif
        if !is_before && !is_behind {
            continue;
        }
        if !knows_normal {
            normal = shadow_normal(pixel.position, pixel.depth, N);
            knows_normal = true;
        }
        var place = position;
        var outward = normal;
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
        if is_behind {
            place -= normal * thickness_of(pixel);
            outward = -normal;
        }
#endif
        set_visibility(shadows, id, directional_shadow(id, place, outward, in_view.z, pixel.position));
    }
}

#ifdef CLUSTERED_DECALS_ARE_USABLE
/// True if a decal at `position` has a normal map, which may turn the surface towards a light behind it.
fn decals_may_turn_normal(pixel: vec2<i32>, position: vec3<f32>, view_z: f32) -> bool {
    let is_orthographic = view_bindings::view.clip_from_view[3].w == 1.0;
    let cluster = view_fragment_cluster_index(vec2<f32>(pixel) + 0.5, view_z, is_orthographic);
    var ranges = unpack_clusterable_object_index_ranges(cluster);
    var decals = clustered_decal_iterator_new(position, &ranges);
    while clustered_decal_iterator_next(&decals) {
        if decals.normal_map_texture_index >= 0 {
            return true;
        }
    }
    return false;
}
#endif
#endif  // FORWARD_MESH
#endif  // DIRECTIONAL_SHADOW_MAPS

fn add_directional_lights(
    point: ptr<function, ShadingPoint>,
    shadows: ptr<function, DirectionalShadows>,
    accumulator: ptr<function, LightAccumulator>,
) {
    let count = view_bindings::lights.n_directional_lights;
    for (var id = 0u; id < count; id++) {
#ifdef LIGHT_LAYERS
        if !directional_light_affects_mesh(id) {
            continue;
        }
#endif
#ifdef LIGHTMAPPED_SURFACES
        let adds_diffuse = !(*point).is_lightmapped || (view_bindings::lights.directional_lights[id].flags
            & mesh_view_types::DIRECTIONAL_LIGHT_FLAGS_AFFECTS_LIGHTMAPPED_MESH_DIFFUSE_BIT) != 0u;
#else
        let adds_diffuse = true;
#endif
        let L = view_bindings::lights.directional_lights[id].direction_to_light;
        if dot((*point).N, L) > 0.0 {
            add_directional_light(point, id, L, adds_diffuse, shadows, accumulator);
        }
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
        if adds_diffuse && transmits(point) && dot((*point).N, L) < 0.0 {
            add_transmitted_directional_light(point, id, L, shadows, accumulator);
        }
#endif
    }
}

#ifdef DIRECTIONAL_SHADOW_MAPS
#ifdef FORWARD_MESH
/// Visibility of the light in its shadow map. Meshes of Bevy's passes know the normal for the bias without reading depth, so that
/// there is nothing to compute before other terms.
fn shadow_at(point: ptr<function, ShadingPoint>, id: u32) -> f32 {
    if !has_shadow_map(id) {
        return 1.0;
    }
    let normal = geometric_normal(point);
    return directional_shadow(id, (*point).position, normal, (*point).view_z, (*point).pixel);
}
#endif
#endif

fn add_directional_light(
    point: ptr<function, ShadingPoint>,
    id: u32,
    L: vec3<f32>,
    adds_diffuse: bool,
    shadows: ptr<function, DirectionalShadows>,
    accumulator: ptr<function, LightAccumulator>,
) {
    var shadow = 1.0;
#ifdef SHADOWS
    if (*point).receives_shadows {
#ifdef DIRECTIONAL_SHADOW_MAPS
#ifdef FORWARD_MESH
        shadow = shadow_at(point, id);
#else
        shadow = visibility_of(shadows, id);
#endif
#endif
#ifdef CONTACT_SHADOWS
        let has_contact_shadows = (view_bindings::lights.directional_lights[id].flags
            & mesh_view_types::DIRECTIONAL_LIGHT_FLAGS_CONTACT_SHADOWS_ENABLED_BIT) != 0u;
        if has_contact_shadows && shadow > 0.0 {
            shadow *= contact_shadow(point, L);
        }
#endif
    }
    if shadow == 0.0 {
        return;
    }
#endif
    let color = color_at(id, (*point).position) * shadow;
    var reflection = response(point, L);
    if !adds_diffuse {
        reflection.diffuse = 0.0;
    }
    accumulate(accumulator, reflection, color);
}

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#ifdef DIRECTIONAL_SHADOW_MAPS
fn sampled_back_shadow_at(point: ptr<function, ShadingPoint>, id: u32) -> f32 {
    if !has_shadow_map(id) {
        return 1.0;
    }
    let normal = -geometric_normal(point);
    return directional_shadow(id, back_position(point), normal, (*point).view_z, (*point).pixel);
}

/// Visibility of the light at the back.
fn back_shadow_at(point: ptr<function, ShadingPoint>, id: u32, shadows: ptr<function, DirectionalShadows>) -> f32 {
#ifdef FORWARD_MESH
    return sampled_back_shadow_at(point, id);
#else ifdef CLUSTERED_DECALS_ARE_USABLE
    // Decals decide which side the light is on.
    return sampled_back_shadow_at(point, id);
#else
    return visibility_of(shadows, id);
#endif
}
#endif

/// Like `add_directional_light`, for light on the back.
fn add_transmitted_directional_light(
    point: ptr<function, ShadingPoint>,
    id: u32,
    L: vec3<f32>,
    shadows: ptr<function, DirectionalShadows>,
    accumulator: ptr<function, LightAccumulator>,
) {
    var shadow = 1.0;
#ifdef DIRECTIONAL_SHADOW_MAPS
    if (*point).back_receives_shadows {
        shadow = back_shadow_at(point, id, shadows);
    }
#endif
    let color = color_at(id, back_position(point));
    (*accumulator).of_model += response_from_behind(point, L) * shadow * color;
}
#endif
