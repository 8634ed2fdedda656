// Marches a ray in segments: for rough surfaces, and for smooth ones whose steps are used up.
#define_import_path bevy_lean_deferred::effects::reflections::rough_march

#import bevy_lean_deferred::effects::reflections::bindings::{depth_in_view, edge_step, hi_z_texture, view}
#import bevy_lean_deferred::cell::{ROWS_BEFORE_16, ROWS_BEFORE_64, largest_rows, unpack_cell}
#import bevy_lean_deferred::effects::reflections::ray::{RayHit, MarchState, depth_inside, pixel_on}
#import bevy_lean_deferred::screen_ray::Ray

/// Largest factor on the length of segments, reached in front of all surfaces.
const LONGER: f32 = 4.0;
/// Segments per iteration. Their reads do not depend on each other's results, so all are issued before the first is used.
const TOGETHER: u32 = 4u;

/// Number of bisections. Segments of up to 2 to this power pixels are bisected down to a pixel.
const HALVINGS: u32 = 8u;

/// Finds the hit between `front`, where the ray is in front of the visible surfaces, and `back`, where it is behind
/// `depth_at_back`. A wall at an angle may be far in front of the ray at `back`, so the interval is bisected towards the point where
/// the ray goes behind. If that is behind by more than the thickness even there, the ray passes an edge: a miss. It is a hit if the
/// ray crosses the depth of the surface within a pixel, which may be longer than the surface is thick. For an `exact` hit, bisection
/// continues to the pixel where the ray enters.
fn hit_between(ray: Ray, direction: vec3<f32>, front: f32, back: f32, depth_at_back: f32, exact: bool) -> RayHit {
    var before = front;
    var after = back;
    var depth_after = depth_at_back;
    var u = back;
    var pixel = pixel_on(ray, u);
    var depth = depth_at_back;
    var is_narrow = false;
    var hit: RayHit;
    for (var i = 0u; i <= HALVINGS + 1u; i++) {
        // Within a pixel the ray crosses the surface, however far it is behind it there.
        let z = select(ray.start.z + ray.step.z * u, depth, is_narrow);
        if z > depth {
            before = u;
        } else {
            after = u;
            depth_after = depth;
            let inside = depth_inside(pixel, depth, z, direction);
            if inside < 1.0 {
                hit = RayHit(true, u, vec3(vec2<f32>(pixel), depth), 1.0 - inside);
                if !exact {
                    break;
                }
            }
        }
        if is_narrow {
            break;
        }
        is_narrow = after - before <= 1.0;
        u = select(0.5 * (before + after), after, is_narrow);
        pixel = pixel_on(ray, u);
        if is_narrow {
            depth = depth_after;
            // The tolerance covers steps between pixels of one surface.
            let z_before = ray.start.z + ray.step.z * before;
            if hit.is_hit || z_before <= depth - edge_step(depth, 1.0) {
                break;
            }
        } else {
            depth = depth_in_view(pixel);
        }
    }
    return hit;
}

/// State of a march in segments.
struct March {
    u: f32,
    is_in_front: bool,
    /// Factor on the length of the next segments, beside their growth.
    factor: f32,
    /// Length of the last segment.
    length: f32,
    /// Number of segments so far.
    segments: u32,
}

/// Interval in which a ray goes behind a surface: in front of it at `front`, and behind `depth` at `back`.
struct Crossing {
    is_one: bool,
    front: f32,
    back: f32,
    depth: f32,
}

/// Marches to the next crossing. Tests the cells and, where these are not conclusive, the pixels in the middle of the segments.
/// `begin` is where the march in segments began.
fn next_crossing(ray: Ray, begin: f32, growth: f32, segments: u32, march: ptr<function, March>) -> Crossing {
    let rows = largest_rows(view.viewport_size.y);
    var now = *march;
    var crossing: Crossing;
    while now.segments < segments && now.u < ray.end {
        let length = max(view.shortest_segment, growth * now.u) * now.factor;
        now.length = length;
        // The smallest cells that are at least as long.
        let is_16 = length > 4.0;
        let is_64 = length > 16.0;
        let inverse_side = select(select(1.0 / 4.0, 1.0 / 16.0, is_16), 1.0 / 64.0, is_64);
        let row = vec2(0, i32(rows * select(select(0u, ROWS_BEFORE_16, is_16), ROWS_BEFORE_64, is_64)));
        let middle = ray.start + ray.step * (now.u + 0.5 * length);
        let along = ray.step * length;
        let cell = middle.xy * inverse_side;
        let along_cell = along.xy * inverse_side;
        let word_0 = textureLoad(hi_z_texture, vec2<i32>(cell) + row, 0).r;
        let word_1 = textureLoad(hi_z_texture, vec2<i32>(cell + along_cell) + row, 0).r;
        let word_2 = textureLoad(hi_z_texture, vec2<i32>(cell + 2.0 * along_cell) + row, 0).r;
        let word_3 = textureLoad(hi_z_texture, vec2<i32>(cell + 3.0 * along_cell) + row, 0).r;
        let cell_0 = unpack_cell(word_0);
        let cell_1 = unpack_cell(word_1);
        let cell_2 = unpack_cell(word_2);
        let cell_3 = unpack_cell(word_3);
        let z = middle.z + vec4(0.0, 1.0, 2.0, 3.0) * along.z;
        let half_z = 0.5 * abs(along.z);
        let is_in_front = z - half_z > vec4(cell_0.x, cell_1.x, cell_2.x, cell_3.x);
        let is_behind = z + half_z < vec4(cell_0.y, cell_1.y, cell_2.y, cell_3.y);
        // It goes behind a surface, may do so, or may come out from behind one.
        let enters = vec4(now.is_in_front, is_in_front.xyz) & is_behind;
        let looks = any(enters | !(is_in_front | is_behind));
        if looks && now.factor > 1.5 {
            // Repeated with shorter segments.
            now.segments += TOGETHER;
            now.factor = 1.0;
            continue;
        }
        var passed = TOGETHER;
        // In place of `crossing`, which would be in registers from iteration to iteration if it were not set at the end alone.
        var found: Crossing;
        if looks {
            let at = min(vec4(now.u) + length * vec4(0.5, 1.5, 2.5, 3.5), vec4(ray.end));
            let depths = vec4(
                depth_in_view(pixel_on(ray, at.x)), depth_in_view(pixel_on(ray, at.y)),
                depth_in_view(pixel_on(ray, at.z)), depth_in_view(pixel_on(ray, at.w)),
            );
            let stays_in_front = is_in_front | (ray.start.z + ray.step.z * at > depths);
            for (var n = 0u; n < TOGETHER; n++) {
                if now.is_in_front && !stays_in_front[n] {
                    found = Crossing(true, max(at[n] - length, begin), at[n], depths[n]);
                    passed = n + 1u;
                }
                now.is_in_front = stays_in_front[n];
                if found.is_one {
                    break;
                }
            }
        } else {
            now.is_in_front = is_in_front.w;
        }
        now.u += f32(passed) * length;
        now.segments += passed;
        now.factor = select(1.0, min(2.0 * now.factor, LONGER), all(is_in_front));
        if found.is_one {
            crossing = found;
            break;
        }
    }
    *march = now;
    return crossing;
}

/// Marches in segments to the first surface whose front faces the ray. Their length grows to `growth` times the distance marched.
/// `direction` is the ray's in view space. Different `phase`s (0 to 1) shift the segments of neighbouring rays, so that one hits
/// what another misses. The march continues from `way`, and ends after this many `segments`. A hit with `is_smooth` is exact to
/// the pixel.
fn march(
    ray: Ray,
    direction: vec3<f32>,
    growth: f32,
    phase: f32,
    segments: u32,
    is_smooth: bool,
    state: ptr<function, MarchState>,
) -> RayHit {
    let begin = (*state).u;
    var march = March(begin, (*state).is_in_front, 0.5 + phase, 0.0, 0u);
    var hit: RayHit;
    loop {
        // Marching and bisection alternate, so that the rays of a subgroup do each together.
        let crossing = next_crossing(ray, begin, growth, segments, &march);
        if !crossing.is_one {
            break;
        }
        // In place of `hit`, for fewer registers: see `next_crossing`.
        let found = hit_between(ray, direction, crossing.front, crossing.back, crossing.depth, is_smooth);
        if found.is_hit {
            hit = found;
            break;
        }
    }
    *state = MarchState(march.u, march.is_in_front, select(march.length, 1.0, is_smooth));
    return hit;
}
