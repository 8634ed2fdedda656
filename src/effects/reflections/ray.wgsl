// A ray through the picture, and its hit.
#define_import_path bevy_lean_deferred::effects::reflections::ray

#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, unpack_normal}
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::screen_ray::{Ray, ray_towards}
#import bevy_lean_deferred::effects::reflections::bindings::{
    behind, depth_in_view, edge_step, facing_viewer, homogeneous_pixel, normal_texture, view,
}

/// Steps of depth that a ray may be behind a surface seen at a grazing angle where it enters a pixel: see `crosses_steep`.
const STEEP: f32 = 4.0;

/// State of a march.
struct MarchState {
    u: f32,
    /// True if the ray is in front of the visible surfaces. It hits those that it enters from in front, and passes behind others.
    is_in_front: bool,
    /// Length of the last step.
    span: f32,
}

/// Result of a march.
struct RayHit {
    is_hit: bool,
    u: f32,
    /// In pixels, and depth.
    place: vec3<f32>,
    /// 1 on the front of a surface, 0 at its thickness behind it.
    certainty: f32,
}

/// Ray from `position`, which is seen at `start` in a view of this `size`, in unit direction `direction`; both in view space.
fn ray_on_screen(start: vec3<f32>, position: vec3<f32>, direction: vec3<f32>, size: vec2<f32>) -> Ray {
    let here = homogeneous_pixel(position, 1.0);
    let towards = homogeneous_pixel(direction, 0.0);
    return ray_towards(start, here, towards, size);
}

/// Pixel that the ray crosses at `u`.
fn pixel_on(ray: Ray, u: f32) -> vec2<i32> {
    return clamp(vec2<i32>(ray.start.xy + ray.step.xy * u), vec2(0), vec2<i32>(view.viewport_size) - 1);
}

/// Share of the assumed thickness that the surface at `pixel` has: 1 where it faces the viewer, less towards silhouettes, and 0
/// where it faces away from the ray.
fn share_of_thickness(pixel: vec2<i32>, depth: f32, direction: vec3<f32>) -> f32 {
    let word = textureLoad(normal_texture, vec2<i32>(view.viewport_origin) + pixel, 0).r;
    // Surfaces outside the G-buffer have the full thickness.
    if word == NO_GEOMETRY {
        return 1.0;
    }
    let normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
    let faces_ray = dot(normal, direction) < 0.0;
    return select(0.0, saturate(facing_viewer(normal, vec2<f32>(pixel) + 0.5, depth)), faces_ray);
}

/// Distance behind the front at `pixel` of a ray that enters it at depth `z`, as a share of the thickness. Above 1, the ray misses.
fn depth_inside(pixel: vec2<i32>, depth: f32, z: f32, direction: vec3<f32>) -> f32 {
    let tolerance = edge_step(depth, 1.0);
    let thickness = depth - behind(depth);
    if z < depth - thickness - tolerance {
        return 2.0;
    }
    let share = share_of_thickness(pixel, depth, direction);
    let inside = max(depth - z - tolerance, 0.0) / max(thickness * share, 1e-30);
    return select(inside, 2.0, share == 0.0);
}

/// Plane of the depths around a pixel.
struct DepthPlane {
    center: vec2<f32>,
    depth: f32,
    /// Depth per pixel.
    slope: vec2<f32>,
}

fn plane_around(pixel: vec2<i32>, depth: f32) -> DepthPlane {
    let slope = vec2(
        flatter_slope(depth_in_view(pixel - vec2(1, 0)), depth, depth_in_view(pixel + vec2(1, 0))),
        flatter_slope(depth_in_view(pixel - vec2(0, 1)), depth, depth_in_view(pixel + vec2(0, 1))),
    );
    return DepthPlane(vec2<f32>(pixel) + 0.5, depth, slope);
}

fn depth_on(plane: DepthPlane, at: vec2<f32>) -> f32 {
    return plane.depth + dot(plane.slope, at - plane.center);
}

/// Distance along the ray at which it crosses the plane.
fn crossing_of(ray: Ray, plane: DepthPlane) -> f32 {
    return (depth_on(plane, ray.start.xy) - ray.start.z) / (ray.step.z - dot(plane.slope, ray.step.xy));
}

/// True for a ray that enters the pixel at depth `z`, and has its middle at `u`, if it crosses a surface that is seen at a grazing angle:
/// depths there step by more than `edge_step` from pixel to pixel.
fn crosses_steep(ray: Ray, pixel: vec2<i32>, depth: f32, z: f32, u: f32) -> bool {
    if z < depth - edge_step(depth, STEEP) {
        return false;
    }
    return abs(crossing_of(ray, plane_around(pixel, depth)) - u) < 1.0;
}

/// Intersects the ray with the plane of the depths around `pixel`. `u` is where the ray crosses the pixel, within a `span` of
/// pixels that it did not sample. `certainty` is that of a ray that comes from behind another surface.
fn hit_at(ray: Ray, pixel: vec2<i32>, depth: f32, u: f32, span: f32, certainty: f32) -> RayHit {
    let plane = plane_around(pixel, depth);
    let exact = crossing_of(ray, plane);
    let is_crossed = abs(exact - u) < 1.0 + span;
    var hit: RayHit;
    hit.is_hit = true;
    hit.u = clamp(select(u, exact, is_crossed), 0.5, ray.end);
    // Within the pixel, because the next one may show another surface.
    hit.place = vec3(ray.start.xy + ray.step.xy * clamp(hit.u, u - 0.4, u + 0.4), 0.0);
    hit.place.z = clamp(depth_on(plane, hit.place.xy), 0.5 * depth, 2.0 * depth);
    // A ray that does not cross the plane here is behind it, by its thickness at most.
    let at = ray.start + ray.step * u;
    let off = depth_on(plane, at.xy) - at.z;
    let inside = max(off, 0.0) / max(depth - behind(depth), 1e-30);
    // Rays that march pixel by pixel cross it within one, others within a segment beside it.
    let is_near = abs(exact - u) < select(1.0, 1.0 + span, span > 1.0);
    // Within a pixel, depths of the ray and of a surface seen at a grazing angle span more than that.
    let is_certain = is_near || abs(off) < 0.5 * (abs(plane.slope.x) + abs(plane.slope.y) + abs(ray.step.z));
    // Falls steeply near 1: curved surfaces, too, are crossed outside of their planes.
    let squared = inside * inside;
    hit.certainty = select(min(certainty, saturate(1.0 - squared * squared)), 1.0, is_certain);
    return hit;
}
