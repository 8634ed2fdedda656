// Marches the ray of a smooth surface through cells and pixels.
#define_import_path bevy_lean_deferred::effects::reflections::smooth_march

#import bevy_lean_deferred::effects::reflections::bindings::{
    behind, depth_texture, edge_step, hi_z_texture, view, view_position,
}
#import bevy_lean_deferred::cell::{ROWS_BEFORE_16, ROWS_BEFORE_64, largest_rows, unpack_cell}
#import bevy_lean_deferred::effects::reflections::ray::{RayHit, MarchState, crosses_steep, depth_inside, ray_on_screen}
#import bevy_lean_deferred::screen_ray::{
    FIRST_SIDE, INTO, LAST_SIDE, Ray, STEP_OF_SIDES, at_metres, cell_ends, cell_place, cell_walk,
    larger_begins,
}

/// Length of a ray in its own pixel, in whose middle it starts.
const OWN_PIXEL: f32 = 0.5;

/// Above the depth of the sky as stored in cells.
const NEAREST_TO_SKY: f32 = 1e-9;

/// A ray that may scatter on its way.
struct Path {
    ray: Ray,
    /// In view space.
    direction: vec3<f32>,
    is_scattered: bool,
}

/// Marches through the largest cells that the ray passes in front of or behind, to the first surface whose front faces it (Uludag
/// 2014, "Hi-Z Screen-Space Cone-Traced Reflections"). After `metres` it goes on in the direction `scattered`, in the same loop. After
/// `steps`, `state` has where the march ended. It begins where the ray leaves its own pixel.
fn march(
    path: ptr<function, Path>,
    scattered: vec3<f32>,
    metres: f32,
    steps: u32,
    state: ptr<function, MarchState>,
) -> RayHit {
    var ray = (*path).ray;
    var direction = (*path).direction;
    var is_scattered = (*path).is_scattered;
    let end = ray.end;
    // Scattered ends are those of another ray.
    ray.end = min(end, at_metres(ray, metres));
    var bends = ray.end < end && !is_scattered;
    var walk = cell_walk(ray);
    let rows = largest_rows(view.viewport_size.y);
    let last = vec2<i32>(view.viewport_size) - 1;
    var side = FIRST_SIDE;
    var u = OWN_PIXEL;
    // The next pixel may show what touches the mirror within the ray's own pixel: it is entered with the depth of the start, and with a
    // tolerance, because what leans to the viewer is nearer there than where it touches. The pixel may also show what hides the
    // mirror: then the ray starts behind it.
    var z = ray.start.z;
    var was_in_front = false;
    var hit: RayHit;
    for (var i = 0u; i < steps && u < ray.end; i++) {
        // A power of 2, whose exponent is negated.
        let inverse_side = bitcast<f32>(0x7f000000u - bitcast<u32>(side));
        let place = cell_place(walk, ray, u, inverse_side);
        let cell = vec2<i32>(place);
        let pixel = clamp(cell, vec2(0), last);
        let is_pixel = side < FIRST_SIDE;
        // Both reads are awaited together, because a subgroup has rays in both.
        var depth = 0.0;
        var word = 0u;
        if is_pixel {
            depth = textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + pixel, 0);
        } else {
            let before = select(select(ROWS_BEFORE_64, ROWS_BEFORE_16, side < LAST_SIDE), 0u, side == FIRST_SIDE);
            word = textureLoad(hi_z_texture, cell + vec2(0, i32(before * rows)), 0).r;
        }
        let ends = cell_ends(walk, ray, place, side);
        let next = min(max(min(ends.x, ends.y), u + INTO), ray.end);
        let next_z = ray.start.z + ray.step.z * next;
        // A ray in front passes behind a single pixel only after a test of the surface's thickness.
        let depths = select(unpack_cell(word), vec2(depth, -1.0), is_pixel);
        var is_in_front = min(z, next_z) > depths.x;
        // A ray that is already behind stays so while it is behind all fronts, regardless of thickness: its depth is shifted like the
        // depths of backs in cells. The lower bound keeps it from passing behind the sky, which cells store as their least depth.
        let nearest = max(z, next_z);
        let reached = select(max(behind(nearest), NEAREST_TO_SKY), nearest, was_in_front);
        var passes = is_in_front || reached < depths.y;
        if !passes && is_pixel {
            is_in_front = next_z > depth;
            let tolerance = select(0.0, edge_step(depth, 1.0), u == OWN_PIXEL);
            if (was_in_front || z > depth - tolerance) && !is_in_front {
                let middle = 0.5 * (u + next);
                // A ray that enters in front of the surface and leaves behind it crosses it, however far behind. The tolerance
                // covers steps between pixels of one surface. Other rays come from beside the surface: its thickness decides.
                let crosses = z > depth - edge_step(depth, 1.0) || crosses_steep(ray, pixel, depth, z, middle);
                let middle_z = ray.start.z + ray.step.z * middle;
                let inside = depth_inside(pixel, depth, select(middle_z, depth, crosses), direction);
                if inside < 1.0 {
                    hit = RayHit(true, middle, vec3(vec2<f32>(pixel), depth), 1.0 - inside);
                    break;
                }
            }
            passes = true;
        }
        if passes {
            u = next;
            z = next_z;
            was_in_front = is_in_front;
            // Goes to larger cells only where one begins.
            let rises = larger_begins(walk, place, ends) && side < LAST_SIDE;
            side *= select(1.0, STEP_OF_SIDES, rises);
            if bends && u >= ray.end {
                let position = view_position(ray.start.xy, ray.start.z) + direction * metres;
                // Signed, so that it is converted here: the unsigned one of the first ray would be in registers throughout the loop.
                let size = vec2<f32>(vec2<i32>(view.viewport_size));
                ray = ray_on_screen(ray.start + ray.step * ray.end, position, scattered, size);
                direction = scattered;
                walk = cell_walk(ray);
                u = 0.0;
                z = ray.start.z;
                bends = false;
                is_scattered = true;
            }
        } else {
            side *= 1.0 / STEP_OF_SIDES;
        }
    }
    ray.end = select(ray.end, end, !is_scattered);
    *path = Path(ray, direction, is_scattered);
    *state = MarchState(u, was_in_front, 1.0);
    return hit;
}
