// A ray on screen: there it is a line, along which depth is affine too. It walks from cell to cell. Without bindings.
#define_import_path bevy_lean_deferred::screen_ray

/// `start + step * u` in (pixel x, pixel y, depth), for `u` from 0 to `end`. `u` grows by about 1 per pixel.
struct Ray {
    start: vec3<f32>,
    step: vec3<f32>,
    end: f32,
    /// The distance from the start is `metres * u / (1 - vanishing * u)`, in metres.
    metres: f32,
    vanishing: f32,
}

/// Parameter at which the line leaves 0 to `size`; 1e9 on axes along which it does not move.
fn leaves(start: vec2<f32>, step: vec2<f32>, size: vec2<f32>) -> f32 {
    let ends = (select(vec2(0.0), size, step > vec2(0.0)) - start) / step;
    let along = abs(step) < vec2(1e-12);
    let never = select(ends, vec2(1e9), along);
    return min(never.x, never.y);
}

/// Ray from `start` in a picture of this `size`. `here` is the homogeneous pixel of its origin, `towards` that of its unit direction.
fn ray_towards(start: vec3<f32>, here: vec4<f32>, towards: vec4<f32>, size: vec2<f32>) -> Ray {
    let step = (towards.xyz - start * towards.w) / here.w;
    var ray: Ray;
    ray.start = start;
    ray.metres = 1.0 / max(max(abs(step.x), abs(step.y)), 1e-6);
    ray.step = step * ray.metres;
    ray.vanishing = ray.metres * towards.w / here.w;
    let sides = leaves(start.xy, ray.step.xy, size);
    let planes = leaves(start.zz, ray.step.zz, vec2(1.0));
    // The vanishing point, at infinite distance.
    let infinity = select(1e9, 1.0 / ray.vanishing, ray.vanishing > 0.0);
    ray.end = min(min(sides, planes), infinity);
    return ray;
}

/// Distance from the start at `u`, in metres.
fn metres_at(ray: Ray, u: f32) -> f32 {
    return ray.metres * u / max(1.0 - ray.vanishing * u, 1e-6);
}

/// `u` at a distance from the start; 1e9 beyond the viewer's plane.
fn at_metres(ray: Ray, metres: f32) -> f32 {
    let along = ray.metres + ray.vanishing * metres;
    return select(1e9, metres / along, along > 0.0);
}

/// Fade towards the edge of a picture of this `size`: 1 from `width` pixels on.
fn rim_fade(at: vec2<f32>, size: vec2<f32>, width: f32) -> f32 {
    let room = min(at, size - at);
    return saturate(min(room.x, room.y) / max(width, 1e-6));
}

/// Sides of the smallest and the largest cells in pixels, and the ratio of consecutive sides. Pixels come before the smallest
/// cells.
const FIRST_SIDE: f32 = 4.0;
const STEP_OF_SIDES: f32 = 4.0;
const LAST_SIDE: f32 = 64.0;
/// Offset into the next cell, in pixels: above rounding errors.
const INTO: f32 = 1.0 / 256.0;

/// Constants of a ray's walk from cell to cell.
struct CellWalk {
    /// Of magnitudes from 1 on, but for rounding: a step is at most a pixel along each axis.
    inverse_step: vec2<f32>,
}

fn cell_walk(ray: Ray) -> CellWalk {
    let step = select(ray.step.xy, vec2(1e-12), abs(ray.step.xy) < vec2(1e-12));
    return CellWalk(1.0 / step);
}

/// 1 along axes on which it moves forwards, else 0. Exact, and not kept in registers.
fn forwards(walk: CellWalk) -> vec2<f32> {
    return saturate(2.0 * walk.inverse_step);
}

/// Number of the cell that the walk enters at `u`, per axis.
fn cell_place(walk: CellWalk, ray: Ray, u: f32, inverse_side: f32) -> vec2<f32> {
    let into = forwards(walk) * (2.0 * INTO) - INTO;
    return floor((ray.start.xy + ray.step.xy * u + into) * inverse_side);
}

/// Parameters at which the walk leaves the cell at `place` along each axis.
fn cell_ends(walk: CellWalk, ray: Ray, place: vec2<f32>, side: f32) -> vec2<f32> {
    return ((place + forwards(walk)) * side - ray.start.xy) * walk.inverse_step;
}

/// True if a larger cell, of 4×4, begins where the walk leaves the cell at `place`, at one of `ends`.
fn larger_begins(walk: CellWalk, place: vec2<f32>, ends: vec2<f32>) -> bool {
    let next = place + forwards(walk);
    return fract(0.25 * select(next.y, next.x, ends.x < ends.y)) == 0.0;
}
