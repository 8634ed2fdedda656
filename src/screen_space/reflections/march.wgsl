// A ray through the picture. On screen it is a line, along which depth is affine too.
#define_import_path bevy_lean_deferred::screen_space::reflections::march

#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, unpack_normal}
#import bevy_lean_deferred::screen_space::reflections::cell::unpack_cell
#import bevy_lean_deferred::screen_space::reflections::bindings::{
    behind, cells_texture, depth_in_view, depth_texture, edge_step, flatter, normal_texture, to_viewer, view, view_position,
}

/// Pixels a side of the steps from pixel to pixel, and of the smallest and the largest cells.
const LEAST_SIDE: f32 = 1.0;
const FIRST_SIDE: f32 = 4.0;
const LAST_SIDE: f32 = 64.0;
/// Into the next cell, in pixels: more than numbers are rounded by.
const INTO: f32 = 1.0 / 256.0;

/// `start + step * u` in (pixel x, pixel y, depth), `u` from 0 to `end`; so a pixel is passed as `u` grows by about 1.
struct Ray {
    start: vec3<f32>,
    step: vec3<f32>,
    end: f32,
    /// Metres from the start are `metres * u / (1 - vanishing * u)`.
    metres: f32,
    vanishing: f32,
}

/// What a ray met.
struct Met {
    is_hit: bool,
    u: f32,
    /// In pixels, and depth.
    place: vec3<f32>,
    /// 1 on the front of a surface, 0 as far behind it as it is thick.
    certainty: f32,
}

/// Where the line leaves 0 to `size`; never if it goes along.
fn leaves(start: vec2<f32>, step: vec2<f32>, size: vec2<f32>) -> f32 {
    let ends = (select(vec2(0.0), size, step > vec2(0.0)) - start) / step;
    let along = abs(step) < vec2(1e-12);
    let never = select(ends, vec2(1e9), along);
    return min(never.x, never.y);
}

/// The ray from `position`, which is seen at `start`, in a direction of unit length; both in view space.
fn ray_on_screen(start: vec3<f32>, position: vec3<f32>, direction: vec3<f32>) -> Ray {
    let here = view.pixel_from_view * vec4(position, 1.0);
    let towards = view.pixel_from_view * vec4(direction, 0.0);
    let step = (towards.xyz - start * towards.w) / here.w;
    var ray: Ray;
    ray.start = start;
    ray.metres = 1.0 / max(max(abs(step.x), abs(step.y)), 1e-6);
    ray.step = step * ray.metres;
    ray.vanishing = ray.metres * towards.w / here.w;
    let sides = leaves(start.xy, ray.step.xy, vec2<f32>(view.viewport_size));
    let planes = leaves(start.zz, ray.step.zz, vec2(1.0));
    // As far away as anything is.
    let infinity = select(1e9, 1.0 / ray.vanishing, ray.vanishing > 0.0);
    ray.end = min(min(sides, planes), infinity);
    return ray;
}

/// How far `u` is from the start, in metres.
fn metres_at(ray: Ray, u: f32) -> f32 {
    return ray.metres * u / max(1.0 - ray.vanishing * u, 1e-6);
}

/// How much of what is at `pixel` may be as thick as surfaces are: 1 where it faces the viewer, less towards outlines; 0 where
/// it turns its back to the ray.
fn depth_of_front(pixel: vec2<i32>, depth: f32, direction: vec3<f32>) -> f32 {
    let word = textureLoad(normal_texture, vec2<i32>(view.viewport_origin) + pixel, 0).r;
    // Who is not in the G-buffer may.
    if word == NO_GEOMETRY {
        return 1.0;
    }
    let normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
    let facing = dot(normal, to_viewer(view_position(vec2<f32>(pixel) + 0.5, depth)));
    return select(0.0, saturate(facing), dot(normal, direction) < 0.0);
}

/// How far behind the front at `pixel` the ray is at depth `z`, as a share of the thickness: above 1 it passes.
fn depth_inside(pixel: vec2<i32>, depth: f32, z: f32, direction: vec3<f32>) -> f32 {
    let tolerance = edge_step(depth, 1.0);
    let thickness = depth - behind(depth);
    if !(depth > 0.0) || z < depth - thickness - tolerance {
        return 2.0;
    }
    let front = depth_of_front(pixel, depth, direction);
    let inside = max(depth - z - tolerance, 0.0) / max(thickness * front, 1e-30);
    return select(inside, 2.0, front == 0.0);
}

/// Goes through cells of a size that leaves the ray alone, up to the first surface that turns its front to it (Uludag
/// 2014, "Hi-Z Screen-Space Cone-Traced Reflections"). `direction` is the ray's in view space; in cells that hold something it looks
/// at depth every `least_span` pixels, at most 4. It is given up after so many `steps`.
fn march(ray: Ray, direction: vec3<f32>, least_span: f32, steps: u32) -> Met {
    let step = select(ray.step.xy, vec2(1e-12), abs(ray.step.xy) < vec2(1e-12));
    let inverse_step = 1.0 / step;
    let ends_from = -ray.start.xy * inverse_step;
    let forwards = vec2<f32>(step > vec2(0.0));
    let start = ray.start.xy + select(vec2(-INTO), vec2(INTO), step > vec2(0.0));
    let rows = i32((view.viewport_size.y + 63u) / 64u);
    let last = vec2<i32>(view.viewport_size) - 1;
    var side = FIRST_SIDE;
    var row = 0;
    // Not the pixel itself.
    var u = 1.0;
    var z = ray.start.z + ray.step.z;
    var at = start + ray.step.xy;
    for (var i = 0u; i < steps && u < ray.end; i++) {
        let span = select(side, least_span, side < FIRST_SIDE);
        let cell = floor(at / span);
        let ends = (cell + forwards) * span * inverse_step + ends_from;
        let next = min(max(min(ends.x, ends.y), u + INTO), ray.end);
        let next_z = ray.start.z + ray.step.z * next;
        let next_at = start + ray.step.xy * next;
        var passes: bool;
        if side < FIRST_SIDE {
            let middle = 0.5 * (u + next);
            let middle_z = 0.5 * (z + next_z);
            let pixel = min(vec2<i32>(0.5 * (at + next_at)), last);
            let depth = textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + pixel, 0);
            passes = middle_z > depth;
            if !passes {
                let inside = depth_inside(pixel, depth, middle_z, direction);
                if inside < 1.0 {
                    return met_at(ray, pixel, depth, middle, span, 1.0 - inside);
                }
                passes = true;
            }
        } else {
            let depths = unpack_cell(textureLoad(cells_texture, vec2<i32>(cell) + vec2(0, row), 0).r);
            passes = min(z, next_z) > depths.x || max(z, next_z) < depths.y;
        }
        var larger = LAST_SIDE;
        var smaller = FIRST_SIDE;
        if side == FIRST_SIDE {
            larger = 16.0;
            smaller = LEAST_SIDE;
        } else if side == LEAST_SIDE {
            larger = FIRST_SIDE;
        }
        if side == LAST_SIDE {
            smaller = 16.0;
        }
        if passes {
            u = next;
            z = next_z;
            at = next_at;
            // Into larger cells only where one begins.
            let entered = floor(at / larger) != floor(cell * span / larger);
            side = select(side, larger, any(entered));
        } else {
            side = smaller;
        }
        row = select(select(0, 16, side > FIRST_SIDE), 20, side == LAST_SIDE) * rows;
    }
    return Met();
}

/// Where the ray meets the plane that the depth around `pixel` tells of; `u` is where it passes the pixel, within a `span` of
/// others that it did not look at, and `certainty` that
/// of a ray that comes from behind something else.
fn met_at(ray: Ray, pixel: vec2<i32>, depth: f32, u: f32, span: f32, certainty: f32) -> Met {
    let slope = vec2(
        flatter(depth_in_view(pixel - vec2(1, 0)), depth, depth_in_view(pixel + vec2(1, 0))),
        flatter(depth_in_view(pixel - vec2(0, 1)), depth, depth_in_view(pixel + vec2(0, 1))),
    );
    let center = vec2<f32>(pixel) + 0.5;
    let along = ray.step.z - dot(slope, ray.step.xy);
    let exact = (depth + dot(slope, ray.start.xy - center) - ray.start.z) / along;
    let is_crossed = abs(exact - u) < 1.0 + span;
    var met: Met;
    met.is_hit = true;
    met.u = clamp(select(u, exact, is_crossed), 0.5, ray.end);
    met.place = vec3(ray.start.xy + ray.step.xy * met.u, 0.0);
    met.place.z = clamp(depth + dot(slope, met.place.xy - center), 0.5 * depth, 2.0 * depth);
    met.certainty = select(certainty, 1.0, is_crossed);
    return met;
}
