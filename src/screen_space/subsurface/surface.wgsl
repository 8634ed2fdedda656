// The surface of a pixel whose light scatters, and where others lie beside it.
#define_import_path bevy_lean_deferred::screen_space::subsurface::surface

#import bevy_lean_deferred::lighting::subsurface_light::Entry
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::reconstruction::position::view_position
#import bevy_lean_deferred::screen_space::subsurface::bindings::{depth_texture, view}
#import bevy_lean_deferred::screen_space::subsurface::profile::REACH

/// A pixel's surface is its tangent plane.
struct Surface {
    /// In view space.
    position: vec3<f32>,
    normal: vec3<f32>,
    /// From this pixel to the next one on the plane, to the right and down.
    right: vec3<f32>,
    down: vec3<f32>,
    /// The longest mean free path, in metres.
    path: f32,
    /// How much the profile shrinks, so as to reach no further than it may: 1 if not at all.
    shrink: f32,
}

/// Depth of a pixel of the viewport, of the nearest one beyond it.
fn depth_in_view(pixel: vec2<i32>) -> f32 {
    let inside = clamp(pixel, vec2(0), vec2<i32>(view.viewport_size) - 1);
    return textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + inside, 0);
}

fn surface_at(pixel: vec2<i32>, paths: vec3<f32>) -> Surface {
    let depth = depth_in_view(pixel);
    let x = vec2(1, 0);
    let y = vec2(0, 1);
    let slope = vec2(
        flatter_slope(depth_in_view(pixel - x), depth, depth_in_view(pixel + x)),
        flatter_slope(depth_in_view(pixel - y), depth, depth_in_view(pixel + y)),
    );
    let at = vec2<f32>(pixel) + 0.5;
    var surface: Surface;
    surface.position = view_position(view.view_from_pixel, vec3(at, depth));
    surface.right = view_position(view.view_from_pixel, vec3(at, depth) + vec3(1.0, 0.0, slope.x)) - surface.position;
    surface.down = view_position(view.view_from_pixel, vec3(at, depth) + vec3(0.0, 1.0, slope.y)) - surface.position;
    surface.normal = normalize(cross(surface.right, surface.down));
    surface.path = max(paths.r, max(paths.g, paths.b));
    let reach = REACH * surface.path * pixels_per_metre_at(-surface.position.z);
    surface.shrink = min(1.0, view.largest_radius / max(reach, 1e-6));
    return surface;
}

/// Along the vertical axis, at so many metres.
fn pixels_per_metre_at(metres: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return abs(view.pixels_per_metre.y);
#else
    return abs(view.pixels_per_metre.y) / max(metres, 1e-6);
#endif
}

/// The pixel, with fractions, of a point in view space.
fn pixel_of(position: vec3<f32>) -> vec2<f32> {
#ifdef PROJECTION_ORTHOGRAPHIC
    return view.center + view.pixels_per_metre * position.xy;
#else
    // Behind the camera nothing is seen.
    return select(vec2(-1.0), view.center - view.pixels_per_metre * position.xy / position.z, position.z < 0.0);
#endif
}

/// In view space, what is so many metres away at a place of the picture.
fn position_of(at: vec2<f32>, metres: f32) -> vec3<f32> {
    let across = (at - view.center) / view.pixels_per_metre;
#ifdef PROJECTION_ORTHOGRAPHIC
    return vec3(across, -metres);
#else
    return vec3(across * metres, -metres);
#endif
}

fn is_in_view(at: vec2<f32>) -> bool {
    return all(at >= vec2(0.0)) && all(at < vec2<f32>(view.viewport_size));
}

/// How much the light of an entry at `at` counts for what is `radius` metres away on the surface: 1 on the tangent plane, 0 on
/// another surface, across a step, or on another material.
fn belongs(surface: Surface, material: u32, entry: Entry, at: vec2<f32>, radius: f32) -> f32 {
    let height = abs(dot(position_of(at, entry.metres) - surface.position, surface.normal));
    let room = surface.shrink * surface.path + 0.25 * radius;
    let near = saturate(2.0 - height / room);
    return select(0.0, near, entry.material == material);
}
