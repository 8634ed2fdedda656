// Culls lights that reach no pixel of a tile.
#define_import_path bevy_lean_deferred::lighting::lights::reach

#import bevy_lean_deferred::lighting::lights::clustered_light::{is_spot_light, spot_direction}
#import bevy_lean_deferred::reconstruction::position::{
    SMALLEST_DEPTH, homogeneous_position, ndc_of_fragment, view_position,
}
#import bevy_lean_deferred::tiles::TILE_SIDE
#import bevy_pbr::mesh_view_bindings::{clustered_lights, view}

/// Bounding box of surfaces in view space.
struct Box {
    least: vec3<f32>,
    most: vec3<f32>,
    /// Distance by which lit points may lie outside: behind their surface, or by rounding.
    slack: f32,
    /// Bounds of the length in metres of a view-space unit vector. Both are 1 unless the camera is scaled.
    scale: vec2<f32>,
}

/// Bounds of the lengths of `m * v` over all unit vectors `v`: the roots of Gershgorin's bounds of the eigenvalues of its Gram
/// matrix. Exact where the axes are orthogonal, as they are unless a parent shears the camera.
fn stretch(m: mat3x3<f32>) -> vec2<f32> {
    let square = vec3(dot(m[0], m[0]), dot(m[1], m[1]), dot(m[2], m[2]));
    let mixed = abs(vec3(dot(m[1], m[2]), dot(m[2], m[0]), dot(m[0], m[1])));
    let others = mixed.yzx + mixed.zxy;
    let least = square - others;
    let most = square + others;
    return sqrt(vec2(max(min(least.x, min(least.y, least.z)), 0.0), max(most.x, max(most.y, most.z))));
}

/// Bounds all points of a tile with depths in this range. `corner` is its first pixel. Light that enters through the back is
/// accumulated up to `reach` metres behind them.
fn box_of_tile(corner: vec2<u32>, depths: vec2<f32>, reach: f32) -> Box {
    let viewport = view.main_pass_viewport;
    let first = ndc_of_fragment(vec2<f32>(corner) + 0.5, viewport);
    let last = ndc_of_fragment(vec2<f32>(corner + TILE_SIDE) - 0.5, viewport);
    let d = max(depths, vec2(SMALLEST_DEPTH));
    let a = view_position(view.view_from_clip, vec3(first, d.x));
    let b = view_position(view.view_from_clip, vec3(first, d.y));
    let c = view_position(view.view_from_clip, vec3(last, d.x));
    let e = view_position(view.view_from_clip, vec3(last, d.y));
    var least = min(min(a, b), min(c, e));
    var most = max(max(a, b), max(c, e));
#ifndef PROJECTION_PERSPECTIVE
#ifndef PROJECTION_ORTHOGRAPHIC
    // Each coordinate may depend on all others. With an oblique near plane, points that are far away in one pixel may lie beyond
    // infinity in another: the box is then unbounded.
    var least_w = 1.0;
    for (var i = 0u; i < 8u; i++) {
        let ndc = select(first, last, vec2((i & 1u) != 0u, (i & 2u) != 0u));
        let h = homogeneous_position(view.view_from_clip, vec3(ndc, select(d.x, d.y, i < 4u)));
        least = min(least, h.xyz / h.w);
        most = max(most, h.xyz / h.w);
        least_w = min(least_w, h.w);
    }
    if !(least_w > 0.0) {
        least = vec3(-1e18);
        most = vec3(1e18);
    }
#endif
#endif
    let axes = view.world_from_view;
    let scale = stretch(mat3x3(axes[0].xyz, axes[1].xyz, axes[2].xyz));
    // Rounding errors grow with the camera's distance from the world's origin and with the distance from the camera.
    let shortest = max(scale.x, 1e-20);
    let origin = abs(view.world_position) / shortest;
    let farthest = max(max(origin.x, origin.y), max(origin.z, max(abs(least.z), abs(most.z))));
    return Box(least, most, 2e-6 * farthest + reach / shortest, scale);
}

/// False if the light with this index reaches no surface in the box.
fn may_reach(bounds: Box, id: u32) -> bool {
    let light = &clustered_lights.data[id];
    let center = (view.view_from_world * vec4((*light).position_radius.xyz, 1.0)).xyz;
    let away = max(max(bounds.least - center, center - bounds.most) - bounds.slack, vec3(0.0));
    let inverse_square_range = (*light).color_inverse_square_range.w;
    // Also false for NaN: such a light has no effect.
    let is_near = dot(away, away) * bounds.scale.x * bounds.scale.x * inverse_square_range < 1.0001;
    // Non-uniform scale turns a cone in world space into another shape in view space.
    let is_even = bounds.scale.y < 1.0001 * bounds.scale.x;
    if !is_near || !is_even || !is_spot_light((*light).flags) {
        return is_near;
    }
    return cone_meets(bounds, id, center);
}

/// Bound of the rounding errors of cosines compared with a cone's, in the shading too.
const COSINE_SLACK: f32 = 1e-6;

/// True if the cone of a spot light intersects the sphere around the box (Wronski 2017, "Cull that cone!").
fn cone_meets(bounds: Box, id: u32, apex: vec3<f32>) -> bool {
    let light = &clustered_lights.data[id];
    let data = (*light).light_custom_data;
    // Root of `data.z * cosine + data.w`. In narrow cones, rounding is a good part of the angle.
    let cosine = clamp(-data.w / data.z - COSINE_SLACK, -1.0, 1.0);
    let world = spot_direction(data.xy, (*light).flags);
    let direction = normalize((view.view_from_world * vec4(world, 0.0)).xyz);
    let to_sphere = 0.5 * (bounds.least + bounds.most) - apex;
    let radius = 0.5 * length(bounds.most - bounds.least) + bounds.slack;
    let along = dot(to_sphere, direction);
    let across = sqrt(max(dot(to_sphere, to_sphere) - along * along, 0.0));
    let sine = sqrt(max((1.0 - cosine) * (1.0 + cosine), 0.0));
    // Distance from the sphere's centre to the cone's side, positive outside.
    let outside = across * cosine - along * sine;
    return !(outside > radius * 1.0001 + 1e-5 * length(to_sphere));
}
