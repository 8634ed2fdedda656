// Marches a ray from a forward mesh: over the hi-z cells of this frame, and from pixel to pixel of the last one inside of them. The depth
// of this frame cannot be read, since the pass that draws the mesh has it attached.
#define_import_path bevy_lean_deferred::lighting::forward::march

#ifdef FORWARD_REFLECTIONS
#import bevy_lean_deferred::cell::{ROWS_BEFORE_16, ROWS_BEFORE_64, largest_rows, unpack_cell}
#import bevy_lean_deferred::lighting::forward::bindings::{hi_z_texture, reflections}
#import bevy_lean_deferred::lighting::forward::last_frame::{
    LastRay, edge_step, kept_distance, kept_surface, last_distance, last_pixel,
}

/// Sides of the smallest and the largest cells in pixels, and the ratio of consecutive sides. Pixels come before the smallest cells.
const FIRST_SIDE: f32 = 4.0;
const STEP_OF_SIDES: f32 = 4.0;
const LAST_SIDE: f32 = 64.0;
/// Offset into the next cell, in pixels: above rounding errors.
const INTO: f32 = 1.0 / 256.0;
/// Length of a ray in its own pixel.
const OWN_PIXEL: f32 = 0.5;
/// Iterations of the search within a pixel (regula falsi).
const NARROWINGS: i32 = 2;

/// `start + step * u` in (pixel x, pixel y, depth), for `u` from 0 to `end`. `u` grows by about 1 per pixel.
struct ForwardRay {
    start: vec3<f32>,
    step: vec3<f32>,
    end: f32,
    /// The distance from the start is `metres * u / (1 - vanishing * u)`, in metres.
    metres: f32,
    vanishing: f32,
}

struct ForwardHit {
    is_hit: bool,
    u: f32,
    /// 1 on the front of a surface, 0 at its thickness behind it.
    certainty: f32,
}

/// Parameter at which a line leaves 0 to `size`; 1e9 on axes along which it does not move.
fn leaves(start: vec2<f32>, step: vec2<f32>, size: vec2<f32>) -> f32 {
    let ends = (select(vec2(0.0), size, step > vec2(0.0)) - start) / step;
    let never = select(ends, vec2(1e9), abs(step) < vec2(1e-12));
    return min(never.x, never.y);
}

/// Ray from `position` in unit `direction`, both in view space.
fn ray_from(position: vec3<f32>, direction: vec3<f32>) -> ForwardRay {
    let here = reflections.pixel_from_view * vec4(position, 1.0);
    let towards = reflections.pixel_from_view * vec4(direction, 0.0);
    let start = here.xyz / here.w;
    let step = (towards.xyz - start * towards.w) / here.w;
    var ray: ForwardRay;
    ray.start = start;
    ray.metres = 1.0 / max(max(abs(step.x), abs(step.y)), 1e-6);
    ray.step = step * ray.metres;
    ray.vanishing = ray.metres * towards.w / here.w;
    let sides = leaves(start.xy, ray.step.xy, vec2<f32>(reflections.viewport_size));
    let planes = leaves(start.zz, ray.step.zz, vec2(1.0));
    // The vanishing point, at infinite distance.
    let infinity = select(1e9, 1.0 / ray.vanishing, ray.vanishing > 0.0);
    ray.end = min(min(sides, planes), infinity);
    return ray;
}

/// Distance from the start at `u`, in metres.
fn metres_at(ray: ForwardRay, u: f32) -> f32 {
    return ray.metres * u / max(1.0 - ray.vanishing * u, 1e-6);
}

/// Metres by which the ray is in front of the surface that the last frame shows in its place.
fn gap_at(ray: ForwardRay, last: LastRay, u: f32) -> f32 {
    let metres = metres_at(ray, u);
    return kept_surface(last_pixel(last, metres)).distance - last_distance(last, metres);
}

/// Where the ray meets a surface between `front` and `back`.
fn narrowed(ray: ForwardRay, last: LastRay, front: f32, back: f32) -> f32 {
    var before = vec2(front, gap_at(ray, last, front));
    var after = vec2(back, gap_at(ray, last, back));
    // Otherwise it comes from beside the surface.
    if !(before.y > 0.0 && after.y <= 0.0) {
        return 0.5 * (front + back);
    }
    var u = back;
    for (var i = 0; i < NARROWINGS; i++) {
        u = mix(before.x, after.x, before.y / (before.y - after.y));
        let gap = gap_at(ray, last, u);
        if gap > 0.0 {
            before = vec2(u, gap);
        } else {
            after = vec2(u, gap);
        }
    }
    return u;
}

/// Marches through the largest cells that the ray passes in front of or behind (Uludag 2014, "Hi-Z Screen-Space Cone-Traced
/// Reflections"), to the first pixel in which it goes behind the surface of the last frame.
fn march(ray: ForwardRay, last: LastRay) -> ForwardHit {
    let step = select(ray.step.xy, vec2(1e-12), abs(ray.step.xy) < vec2(1e-12));
    let inverse_step = 1.0 / step;
    let ends_from = -ray.start.xy * inverse_step;
    let is_forward = step > vec2(0.0);
    let forwards = vec2<f32>(is_forward);
    // Coordinates of the last of 4×4 cells in a larger one, in the ray's direction.
    let last_of_four = select(vec2(0), vec2(3), is_forward);
    let start = ray.start.xy + select(vec2(-INTO), vec2(INTO), is_forward);
    let rows = largest_rows(reflections.viewport_size.y);
    var side = FIRST_SIDE;
    var u = OWN_PIXEL;
    var was_in_front = false;
    var hit: ForwardHit;
    for (var i = 0u; i < reflections.steps && u < ray.end; i++) {
        let inverse_side = 1.0 / side;
        let place = floor((start + ray.step.xy * u) * inverse_side);
        let cell = vec2<i32>(place);
        let ends = (place + forwards) * (side * inverse_step) + ends_from;
        let next = min(max(min(ends.x, ends.y), u + INTO), ray.end);
        var passes = true;
        if side < FIRST_SIDE {
            let middle = metres_at(ray, 0.5 * (u + next));
            let kept = kept_distance(last_pixel(last, middle));
            let entry = last_distance(last, metres_at(ray, u));
            let exit = last_distance(last, metres_at(ray, next));
            let is_in_front = exit < kept;
            if (was_in_front || entry < kept) && !is_in_front {
                // A ray that enters in front of the surface crosses it, however far behind it leaves. The tolerance covers steps
                // between pixels of one surface. Other rays come from beside the surface: its thickness decides, and it faces only
                // those that go away from the viewer.
                let tolerance = edge_step(kept);
                let inside = (last_distance(last, middle) - kept - tolerance) / max(reflections.thickness, 1e-30);
                let is_crossed = entry < kept + tolerance;
                let behind = select(select(2.0, max(inside, 0.0), exit > entry), 0.0, is_crossed);
                if behind < 1.0 {
                    hit = ForwardHit(true, narrowed(ray, last, u, next), 1.0 - behind);
                    break;
                }
            }
            was_in_front = is_in_front;
        } else {
            let before = select(select(ROWS_BEFORE_64, ROWS_BEFORE_16, side < LAST_SIDE), 0u, side == FIRST_SIDE);
            let depths = unpack_cell(textureLoad(hi_z_texture, cell + vec2(0, i32(before * rows)), 0).r);
            let z = ray.start.z + ray.step.z * vec2(u, next);
            let is_in_front = min(z.x, z.y) > depths.x;
            passes = is_in_front || max(z.x, z.y) < depths.y;
            was_in_front = select(was_in_front, is_in_front, passes);
        }
        if passes {
            u = next;
            // Goes to larger cells only where one begins.
            let crossed = select(cell.y ^ last_of_four.y, cell.x ^ last_of_four.x, ends.x < ends.y);
            side *= select(1.0, STEP_OF_SIDES, (crossed & 3) == 0 && side < LAST_SIDE);
        } else {
            side *= 1.0 / STEP_OF_SIDES;
        }
    }
    return hit;
}
#endif  // FORWARD_REFLECTIONS
