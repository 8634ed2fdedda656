// Geometric normal of the surface in a depth texture. Without bindings: the texture is passed in.
#define_import_path bevy_lean_deferred::reconstruction::normal_from_depth

#import bevy_lean_deferred::reconstruction::{
    normal::{normal_from_positions, normal_from_slope, straighter_side},
    position::{ray_at, view_position},
}

/// Further from any surface than the neighbour on the other side can be, so that the other side is chosen.
const OUTSIDE: f32 = 1e9;

/// Area of a view in a depth texture. Pixel coordinates are relative to the view's corner.
struct DepthView {
    origin: vec2<i32>,
    size: vec2<i32>,
}

/// Depths one and two pixels from a pixel along the axes; `OUTSIDE` where there is no surface.
struct DepthsAround {
    left: vec2<f32>,
    right: vec2<f32>,
    top: vec2<f32>,
    bottom: vec2<f32>,
}

/// Depth at `pixel`, or `OUTSIDE`. `is_inside` must only be set if the pixel lies in the view.
fn depth_or_outside(depths: texture_depth_2d, view: DepthView, pixel: vec2<i32>, is_inside: bool) -> f32 {
    if !is_inside && !(all(pixel >= vec2(0)) && all(pixel < view.size)) {
        return OUTSIDE;
    }
    let depth = textureLoad(depths, view.origin + pixel, 0);
    // The sky is no neighbour either, though its depth of 0 may be the nearer one at a horizon.
    return select(OUTSIDE, depth, depth > 0.0);
}

/// Depths one and two steps from `pixel`.
fn depths_along(
    depths: texture_depth_2d,
    view: DepthView,
    pixel: vec2<i32>,
    step: vec2<i32>,
    is_inside: bool,
) -> vec2<f32> {
    return vec2(
        depth_or_outside(depths, view, pixel + step, is_inside),
        depth_or_outside(depths, view, pixel + 2 * step, is_inside),
    );
}

/// `is_inside` must only be set if all of them lie in the view.
fn depths_around(depths: texture_depth_2d, view: DepthView, pixel: vec2<i32>, is_inside: bool) -> DepthsAround {
    return DepthsAround(
        depths_along(depths, view, pixel, vec2(-1, 0), is_inside),
        depths_along(depths, view, pixel, vec2(1, 0), is_inside),
        depths_along(depths, view, pixel, vec2(0, -1), is_inside),
        depths_along(depths, view, pixel, vec2(0, 1), is_inside),
    );
}

/// Depth two pixels away, or one pixel away if there is none, so that nearness alone decides.
fn second_depth(depths: vec2<f32>) -> f32 {
    return select(depths.y, depths.x, depths.y == OUTSIDE);
}

/// Depth of the neighbour on the chosen side. A centre in front of both sides, or without any, is a ridge or too thin to have a
/// neighbour on its own surface: it faces the viewer.
fn depth_on_side(center: f32, before: f32, after: f32, side: f32) -> f32 {
    let faces_viewer = max(before, after) < center || min(before, after) == OUTSIDE;
    return select(select(before, after, side > 0.0), center, faces_viewer);
}

/// Unit normal, facing the viewer, of the surface at a pixel with this `center`, `position` and these depths. `pixels_per_ray` is in
/// pixels per unit of `ray_at`. Nine taps: see `straighter_side`.
fn geometric_normal(
    view_from_pixel: mat4x4<f32>,
    pixels_per_ray: vec2<f32>,
    center: vec2<f32>,
    position: vec3<f32>,
    to_viewer: vec3<f32>,
    depth: f32,
    around: DepthsAround,
) -> vec3<f32> {
    let h = straighter_side(
        depth,
        around.left.x, second_depth(around.left),
        around.right.x, second_depth(around.right),
    );
    let v = straighter_side(
        depth,
        around.top.x, second_depth(around.top),
        around.bottom.x, second_depth(around.bottom),
    );
    let horizontal = depth_on_side(depth, around.left.x, around.right.x, h);
    let vertical = depth_on_side(depth, around.top.x, around.bottom.x, v);
    let slope = vec2((horizontal - depth) * h, (vertical - depth) * v);
#ifdef PROJECTION_PERSPECTIVE
    return normal_from_slope(view_from_pixel, ray_at(view_from_pixel, center), depth, slope * pixels_per_ray);
#else ifdef PROJECTION_ORTHOGRAPHIC
    return normal_from_slope(view_from_pixel, ray_at(view_from_pixel, center), depth, slope * pixels_per_ray);
#else
    let n = normal_from_positions(
        position,
        view_position(view_from_pixel, vec3(center + vec2(h, 0.0), horizontal)), h,
        view_position(view_from_pixel, vec3(center + vec2(0.0, v), vertical)), v,
    );
    // A mirrored projection reverses the order of the taps, and thus the normal.
    return select(n, -n, dot(n, to_viewer) < 0.0);
#endif
}
