// Light from one point or spot light, like Bevy's `point_light` and `spot_light`.
#define_import_path bevy_lean_deferred::lighting::lights::clustered_light

#import bevy_lean_deferred::lighting::lights::brdf::{LightAccumulator, LEAST_SQUARE, Response, accumulate, response}
#import bevy_lean_deferred::lighting::lights::shading_point::ShadingPoint
#import bevy_pbr::{
    lighting::getRangeFalloff,
    mesh_view_bindings::clustered_lights,
    mesh_view_types,
}

#ifdef SPHERE_LIGHTS
#import bevy_lean_deferred::lighting::lights::brdf::response_to_sphere
#endif

#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::light_layers::clustered_light_affects_mesh
#endif

#ifdef LIGHT_TEXTURES
#import bevy_pbr::lighting::cubemap_uv
#import bevy_pbr::mesh_view_bindings as view_bindings
#endif

#ifdef CLUSTERED_SHADOW_MAPS
#import bevy_lean_deferred::lighting::lights::shading_point::geometric_normal
#import bevy_lean_deferred::lighting::bevy::shadow_maps::clustered_shadow
#endif

#ifdef CONTACT_SHADOWS
#import bevy_lean_deferred::lighting::bevy::contact_shadow::contact_shadow
#endif

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#import bevy_lean_deferred::lighting::lights::brdf::response_from_behind
#import bevy_lean_deferred::lighting::lights::shading_point::{back_position, transmits}
#endif

fn is_spot_light(flags: u32) -> bool {
#ifdef SPOT_LIGHTS
    return (flags & mesh_view_types::POINT_LIGHT_FLAGS_SPOT_LIGHT_BIT) != 0u;
#else
    return false;
#endif
}

/// Inverse-square falloff like Bevy's: constant below a centimetre, and 0 at the light's range.
fn attenuation(distance_square: f32, inverse_distance: f32, inverse_square_range: f32) -> f32 {
    let inverse_square = min(inverse_distance * inverse_distance, 1e4);
    return getRangeFalloff(distance_square, inverse_square_range) * inverse_square;
}

/// Direction in which a spot light points.
fn spot_direction(custom_data: vec2<f32>, flags: u32) -> vec3<f32> {
    let y = sqrt(max(0.0, 1.0 - dot(custom_data, custom_data)));
    let is_down = (flags & mesh_view_types::POINT_LIGHT_FLAGS_SPOT_LIGHT_Y_NEGATIVE) != 0u;
    return vec3(custom_data.x, select(y, -y, is_down), custom_data.y);
}

/// Factor of the light with this index for a surface from which it lies in direction `L`: 0 outside a spot light's cone, and
/// where its layers exclude the mesh.
fn directed_strength(id: u32, flags: u32, is_spot: bool, L: vec3<f32>) -> f32 {
    var strength = 1.0;
    if is_spot {
        let data = clustered_lights.data[id].light_custom_data;
        let falloff = saturate(dot(-spot_direction(data.xy, flags), L) * data.z + data.w);
        strength = falloff * falloff;
    }
#ifdef LIGHT_LAYERS
    if !clustered_light_affects_mesh(id) {
        strength = 0.0;
    }
#endif
    return strength;
}

#ifdef LIGHT_TEXTURES
/// Factor of the light's texture towards `position`.
fn texture_of(id: u32, is_spot: bool, position: vec3<f32>) -> f32 {
    let light = &clustered_lights.data[id];
    let index = (*light).decal_index;
    if index == 0xffffffffu {
        return 1.0;
    }
    let decal = &view_bindings::clustered_decals.decals[index];
    let local = ((*decal).local_from_world * vec4(position, 1.0)).xyz;
    var uv: vec2<f32>;
    if is_spot {
        if local.z >= 0.0 {
            return 1.0;
        }
        uv = local.xy / (local.z * (*light).spot_light_tan_angle) * vec2(-0.5, 0.5) + 0.5;
    } else {
        uv = cubemap_uv(local, (*decal).tag);
    }
    return textureSampleLevel(
        view_bindings::clustered_decal_textures[(*decal).base_color_texture_index],
        view_bindings::clustered_decal_sampler,
        uv,
        0.0,
    ).r;
}
#endif

/// Adds the light with this index.
fn add_clustered_light(point: ptr<function, ShadingPoint>, id: u32, accumulator: ptr<function, LightAccumulator>) {
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    // Both sides by one call, so that shadows are compiled once.
#ifdef SPHERE_LIGHTS
    let sides = select(1u, 2u, transmits(point));
    for (var side = 0u; side < sides; side++) {
        add_light_on(side == 1u, point, id, accumulator);
    }
#else
    // Without a radius, a light is on one side alone.
    let to_light = clustered_lights.data[id].position_radius.xyz - (*point).position;
    add_light_on(transmits(point) && dot((*point).N, to_light) <= 0.0, point, id, accumulator);
#endif
#else
    add_light_on(false, point, id, accumulator);
#endif
}

/// Adds the light on the front, or that on the back of a surface which transmits it. Lights out of range are rejected first: most
/// lights near a tile do not reach each of its pixels.
fn add_light_on(
    is_back: bool,
    point: ptr<function, ShadingPoint>,
    id: u32,
    accumulator: ptr<function, LightAccumulator>,
) {
    let light = &clustered_lights.data[id];
    let position_radius = (*light).position_radius;
    let inverse_square_range = (*light).color_inverse_square_range.w;
    var position = (*point).position;
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    if is_back {
        position = back_position(point);
    }
#endif
    let to_light = position_radius.xyz - position;
    let distance_square = dot(to_light, to_light);
    let height = dot((*point).N, to_light);
    let reaches = select(height + position_radius.w > 0.0, height < 0.0, is_back);
    // Also rejects NaN.
    if !(distance_square * inverse_square_range < 1.0 && reaches) {
        return;
    }
    // The surface may pass through the centre of a light with a radius.
    let inverse_distance = inverseSqrt(max(distance_square, LEAST_SQUARE));
    let L = to_light * inverse_distance;
    let flags = (*light).flags;
    let is_spot = is_spot_light(flags);
    var strength = attenuation(distance_square, inverse_distance, inverse_square_range)
        * directed_strength(id, flags, is_spot, L);
    if strength == 0.0 {
        return;
    }
    var adds_diffuse = true;
#ifdef LIGHTMAPPED_SURFACES
    adds_diffuse = !(*point).is_lightmapped
        || (flags & mesh_view_types::POINT_LIGHT_FLAGS_AFFECTS_LIGHTMAPPED_MESH_DIFFUSE_BIT) != 0u;
    if is_back && !adds_diffuse {
        return;
    }
#endif
#ifdef SHADOWS
    if receives_shadows_on(is_back, point) {
        strength *= shadow_on(is_back, point, id, flags, is_spot, position, L);
        if strength == 0.0 {
            return;
        }
    }
#endif
#ifdef LIGHT_TEXTURES
    strength *= texture_of(id, is_spot, position);
#endif
    // Read late: most lights do not get here, and shadows take many registers.
    let color = (*light).color_inverse_square_range.rgb * strength;

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    if is_back {
        (*accumulator).of_model += response_from_behind(point, L) * color;
        return;
    }
#endif
#ifdef SPHERE_LIGHTS
    var reflection: Response;
    if position_radius.w > 0.0 {
        reflection = response_to_sphere(point, to_light, position_radius.w);
    } else {
        reflection = response(point, L);
    }
#else
    var reflection = response(point, L);
#endif
    if !adds_diffuse {
        reflection.diffuse = 0.0;
    }
    accumulate(accumulator, reflection, color);
}

#ifdef SHADOWS
fn receives_shadows_on(is_back: bool, point: ptr<function, ShadingPoint>) -> bool {
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    return select((*point).receives_shadows, (*point).back_receives_shadows, is_back);
#else
    return (*point).receives_shadows;
#endif
}

/// Shadow factor: 0 where the light is occluded.
fn shadow_on(
    is_back: bool,
    point: ptr<function, ShadingPoint>,
    id: u32,
    flags: u32,
    is_spot: bool,
    position: vec3<f32>,
    L: vec3<f32>,
) -> f32 {
    var shadow = 1.0;
#ifdef CLUSTERED_SHADOW_MAPS
    if (flags & mesh_view_types::POINT_LIGHT_FLAGS_SHADOWS_ENABLED_BIT) != 0u {
        let normal = geometric_normal(point);
        shadow = clustered_shadow(id, is_spot, position, select(normal, -normal, is_back), (*point).pixel);
    }
#endif
#ifdef CONTACT_SHADOWS
    let has_contact_shadows = !is_back
        && (flags & mesh_view_types::POINT_LIGHT_FLAGS_CONTACT_SHADOWS_ENABLED_BIT) != 0u;
    if has_contact_shadows && shadow > 0.0 {
        shadow *= contact_shadow(point, L);
    }
#endif
    return shadow;
}
#endif
