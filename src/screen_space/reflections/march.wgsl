// A ray through the picture. On screen it is a line, along which depth is affine too.
#define_import_path bevy_lean_deferred::screen_space::reflections::march

#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, unpack_normal}
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::screen_space::reflections::cell::unpack_cell
#import bevy_lean_deferred::screen_space::reflections::bindings::{
    behind, cells_texture, depth_in_view, depth_texture, edge_step, normal_texture, to_viewer, view, view_position,
}

/// Pixels a side of the smallest and the largest cells, and how many times larger the next ones are. Pixels come before the
/// smallest.
const FIRST_SIDE: f32 = 4.0;
const STEP_OF_SIDES: f32 = 4.0;
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

/// What share of the thickness that surfaces have is that of what is at `pixel`: 1 where it faces the viewer, less towards
/// outlines; 0 where it turns its back to the ray.
fn share_of_thickness(pixel: vec2<i32>, depth: f32, direction: vec3<f32>) -> f32 {
    let word = textureLoad(normal_texture, vec2<i32>(view.viewport_origin) + pixel, 0).r;
    // Who is not in the G-buffer may.
    if word == NO_GEOMETRY {
        return 1.0;
    }
    let normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
    let facing = dot(normal, to_viewer(view_position(vec2<f32>(pixel) + 0.5, depth)));
    return select(0.0, saturate(facing), dot(normal, direction) < 0.0);
}

/// How far behind the front at `pixel` a ray is that enters it at depth `z`, as a share of the thickness: above 1 it passes.
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

/// Goes through the largest cells that leave the ray alone, up to the first surface that turns its front to it (Uludag 2014,
/// "Hi-Z Screen-Space Cone-Traced Reflections"). `direction` is the ray's in view space. It looks at depth in each pixel, or
/// where `spread` is more than 0, once in cells as large as `spread` times the way on screen, at least the smallest. It is
/// given up after so many `steps`.
fn march(ray: Ray, direction: vec3<f32>, spread: f32, steps: u32) -> Met {
    let step = select(ray.step.xy, vec2(1e-12), abs(ray.step.xy) < vec2(1e-12));
    let inverse_step = 1.0 / step;
    let ends_from = -ray.start.xy * inverse_step;
    let is_forward = step > vec2(0.0);
    let forwards = vec2<f32>(is_forward);
    // Of the last cell in a larger one.
    let last_of_four = select(vec2(0), vec2(3), is_forward);
    let start = ray.start.xy + select(vec2(-INTO), vec2(INTO), is_forward);
    let rows = i32((view.viewport_size.y + 63u) / 64u);
    let last = vec2<i32>(view.viewport_size) - 1;
    let smallest = select(1.0, FIRST_SIDE, spread > 0.0);
    var side = FIRST_SIDE;
    var inverse_side = 1.0 / FIRST_SIDE;
    // Not the pixel itself.
    var u = 1.0;
    var z = ray.start.z + ray.step.z;
    // What it does not enter from in front it passes behind.
    var was_in_front = true;
    var met: Met;
    for (var i = 0u; i < steps && u < ray.end; i++) {
        let at = start + ray.step.xy * u;
        let place = floor(at * inverse_side);
        let cell = vec2<i32>(place);
        let ends = (place + forwards) * (side * inverse_step) + ends_from;
        let next = min(max(min(ends.x, ends.y), u + INTO), ray.end);
        let next_z = ray.start.z + ray.step.z * next;
        var depths: vec2<f32>;
        if side < FIRST_SIDE {
            depths = vec2(textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + min(cell, last), 0), -1.0);
        } else {
            let row = select(select(20, 16, side < LAST_SIDE), 0, side == FIRST_SIDE);
            depths = unpack_cell(textureLoad(cells_texture, cell + vec2(0, row * rows), 0).r);
        }
        var is_in_front = min(z, next_z) > depths.x;
        var passes = is_in_front || max(z, next_z) < depths.y;
        if !passes && side <= max(spread * u, smallest) {
            let middle = 0.5 * (u + next);
            let middle_z = 0.5 * (z + next_z);
            let pixel = clamp(vec2<i32>(ray.start.xy + ray.step.xy * middle), vec2(0), last);
            // Of a single pixel it is known already.
            var depth = depths.x;
            if side >= FIRST_SIDE {
                depth = textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + pixel, 0);
            }
            is_in_front = middle_z > depth;
            if was_in_front && !is_in_front {
                let inside = depth_inside(pixel, depth, middle_z, direction);
                if inside < 1.0 {
                    met = Met(true, middle, vec3(vec2<f32>(pixel), depth), 1.0 - inside);
                    break;
                }
            }
            passes = true;
        }
        if passes {
            u = next;
            z = next_z;
            was_in_front = is_in_front;
            // Into larger cells only where one begins.
            let crosses_x = ends.x < ends.y;
            let crossed = select(cell.y ^ last_of_four.y, cell.x ^ last_of_four.x, crosses_x);
            let rises = (crossed & 3) == 0 && side < LAST_SIDE;
            side *= select(1.0, STEP_OF_SIDES, rises);
            inverse_side *= select(1.0, 1.0 / STEP_OF_SIDES, rises);
        } else {
            side *= 1.0 / STEP_OF_SIDES;
            inverse_side *= STEP_OF_SIDES;
        }
    }
    // Here, where rays that ended at different times are together again.
    if met.is_hit {
        met = met_at(ray, vec2<i32>(met.place.xy), met.place.z, met.u, side, met.certainty);
    }
    return met;
}

/// Where the ray meets the plane that the depth around `pixel` tells of; `u` is where it passes the pixel, within a `span` of
/// others that it did not look at, and `certainty` that of a ray that comes from behind something else.
fn met_at(ray: Ray, pixel: vec2<i32>, depth: f32, u: f32, span: f32, certainty: f32) -> Met {
    let slope = vec2(
        flatter_slope(depth_in_view(pixel - vec2(1, 0)), depth, depth_in_view(pixel + vec2(1, 0))),
        flatter_slope(depth_in_view(pixel - vec2(0, 1)), depth, depth_in_view(pixel + vec2(0, 1))),
    );
    let center = vec2<f32>(pixel) + 0.5;
    let along = ray.step.z - dot(slope, ray.step.xy);
    let exact = (depth + dot(slope, ray.start.xy - center) - ray.start.z) / along;
    let is_crossed = abs(exact - u) < 1.0 + span;
    var met: Met;
    met.is_hit = true;
    met.u = clamp(select(u, exact, is_crossed), 0.5, ray.end);
    // Within the pixel: the next one may show something else.
    met.place = vec3(ray.start.xy + ray.step.xy * clamp(met.u, u - 0.4, u + 0.4), 0.0);
    met.place.z = clamp(depth + dot(slope, met.place.xy - center), 0.5 * depth, 2.0 * depth);
    met.certainty = select(certainty, 1.0, is_crossed);
    return met;
}
