// The normal of the surface that a depth texture shows. Without bindings: the texture is passed in.
#define_import_path bevy_lean_deferred::reconstruction::normal_from_depth

#import bevy_lean_deferred::reconstruction::{
    normal::{normal_from_positions, straighter_side},
    position::view_position,
}

/// Further from any surface than the other side of an axis can be, so that that is chosen.
const OUTSIDE: f32 = 1e9;

/// Where in a depth texture a view is. Pixels count from the view's corner.
struct DepthView {
    /// From (pixel x, pixel y, depth, 1) to view space, homogeneous.
    view_from_pixel: mat4x4<f32>,
    origin: vec2<i32>,
    size: vec2<i32>,
}

fn position_in(view: DepthView, pixel: vec2<i32>, depth: f32) -> vec3<f32> {
    return view_position(view.view_from_pixel, vec3(vec2<f32>(pixel) + 0.5, depth));
}

fn depth_or_outside(depths: texture_depth_2d, view: DepthView, pixel: vec2<i32>, is_inside: bool) -> f32 {
    if !is_inside && !(all(pixel >= vec2(0)) && all(pixel < view.size)) {
        return OUTSIDE;
    }
    let depth = textureLoad(depths, view.origin + pixel, 0);
    // Nor is the sky a neighbour, though its depth of 0 may be the nearer one at a horizon.
    return select(OUTSIDE, depth, depth > 0.0);
}

/// Depth of the neighbour's neighbour; the neighbour's where there is none, which leaves nearness alone to choose by.
fn second_depth(
    depths: texture_depth_2d,
    view: DepthView,
    pixel: vec2<i32>,
    first: f32,
    is_inside: bool,
) -> f32 {
    let second = depth_or_outside(depths, view, pixel, is_inside);
    return select(second, first, second == OUTSIDE);
}

/// Depth of the neighbour on the chosen side. What stands before both sides, or has none, is a ridge or too thin to have
/// a neighbour of its own surface: it faces the viewer.
fn depth_on_side(center: f32, before: f32, after: f32, side: f32) -> f32 {
    let faces_viewer = max(before, after) < center || min(before, after) == OUTSIDE;
    return select(select(before, after, side > 0.0), center, faces_viewer);
}

/// The unit normal of the surface at `pixel`, where its `position` is and `depth` is known, towards the viewer. Nine taps:
/// see `straighter_side`. `is_inside` says that none of them lies outside of the view.
fn geometric_normal(
    depths: texture_depth_2d,
    view: DepthView,
    pixel: vec2<i32>,
    position: vec3<f32>,
    to_viewer: vec3<f32>,
    depth: f32,
    is_inside: bool,
) -> vec3<f32> {
    let x = vec2(1, 0);
    let y = vec2(0, 1);
    let left = depth_or_outside(depths, view, pixel - x, is_inside);
    let right = depth_or_outside(depths, view, pixel + x, is_inside);
    let top = depth_or_outside(depths, view, pixel - y, is_inside);
    let bottom = depth_or_outside(depths, view, pixel + y, is_inside);
    let h = straighter_side(
        depth,
        left, second_depth(depths, view, pixel - 2 * x, left, is_inside),
        right, second_depth(depths, view, pixel + 2 * x, right, is_inside),
    );
    let v = straighter_side(
        depth,
        top, second_depth(depths, view, pixel - 2 * y, top, is_inside),
        bottom, second_depth(depths, view, pixel + 2 * y, bottom, is_inside),
    );
    let n = normal_from_positions(
        position,
        position_in(view, pixel + i32(h) * x, depth_on_side(depth, left, right, h)), h,
        position_in(view, pixel + i32(v) * y, depth_on_side(depth, top, bottom, v)), v,
    );
    return select(n, -n, dot(n, to_viewer) < 0.0);
}
