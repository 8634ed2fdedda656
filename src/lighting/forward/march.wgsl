// Marches a ray from a forward mesh: over the hi-z cells of this frame, and from pixel to pixel of the last one inside of them. The depth
// of this frame cannot be read, since the pass that draws the mesh has it attached.
#define_import_path bevy_lean_deferred::lighting::forward::march

#ifdef FORWARD_REFLECTIONS
#import bevy_lean_deferred::cell::{ROWS_BEFORE_16, ROWS_BEFORE_64, largest_rows, unpack_cell}
#import bevy_lean_deferred::lighting::forward::bindings::{hi_z_texture, reflections}
#import bevy_lean_deferred::lighting::forward::last_frame::{
    LastRay, edge_step, kept_distance, kept_surface, last_distance, last_pixel,
}
#import bevy_lean_deferred::screen_ray::{
    FIRST_SIDE, INTO, LAST_SIDE, Ray, STEP_OF_SIDES, cell_ends, cell_place, cell_walk, larger_begins, metres_at,
    ray_towards,
}

/// Length of a ray in its own pixel.
const OWN_PIXEL: f32 = 0.5;
/// Iterations of the search within a pixel (regula falsi).
const NARROWINGS: i32 = 2;

struct ForwardHit {
    is_hit: bool,
    u: f32,
    /// 1 on the front of a surface, 0 at its thickness behind it.
    certainty: f32,
}

/// Ray from `position` in unit `direction`, both in view space.
fn ray_from(position: vec3<f32>, direction: vec3<f32>) -> Ray {
    let here = reflections.pixel_from_view * vec4(position, 1.0);
    let towards = reflections.pixel_from_view * vec4(direction, 0.0);
    let start = here.xyz / here.w;
    return ray_towards(start, here, towards, vec2<f32>(reflections.viewport_size));
}

/// Metres by which the ray is in front of the surface that the last frame shows in its place.
fn gap_at(ray: Ray, last: LastRay, u: f32) -> f32 {
    let metres = metres_at(ray, u);
    return kept_surface(last_pixel(last, metres)).distance - last_distance(last, metres);
}

/// Parameter at which the ray meets a surface between `front` and `back`.
fn narrowed(ray: Ray, last: LastRay, front: f32, back: f32) -> f32 {
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
fn march(ray: Ray, last: LastRay) -> ForwardHit {
    let walk = cell_walk(ray);
    let rows = largest_rows(reflections.viewport_size.y);
    var side = FIRST_SIDE;
    var u = OWN_PIXEL;
    var was_in_front = false;
    var hit: ForwardHit;
    for (var i = 0u; i < reflections.steps && u < ray.end; i++) {
        let inverse_side = 1.0 / side;
        let place = cell_place(walk, ray, u, inverse_side);
        let cell = vec2<i32>(place);
        let ends = cell_ends(walk, ray, place, side);
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
            side *= select(1.0, STEP_OF_SIDES, larger_begins(walk, place, ends) && side < LAST_SIDE);
        } else {
            side *= 1.0 / STEP_OF_SIDES;
        }
    }
    return hit;
}
#endif  // FORWARD_REFLECTIONS
