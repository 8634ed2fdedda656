// Horizon-based ambient occlusion: Bavoil and Sainz 2008, "Image-space horizon-based ambient occlusion".
#define_import_path bevy_lean_deferred::effects::ambient_occlusion::hbao

#import bevy_lean_deferred::effects::ambient_occlusion::bindings::{
    depth_texture, direction_to_viewer, largest_side, radius_at, view,
}
#import bevy_lean_deferred::horizon::{side_occlusion, slice_normal, tangents}
#import bevy_lean_deferred::reconstruction::normal_from_depth::{DepthsAround, geometric_normal}
#import bevy_lean_deferred::reconstruction::position::{
    direction_on_screen, homogeneous_steps, position_on, ray_at, ray_slope, ray_step, w_at,
}
#import bevy_lean_deferred::rounding::{Start, rounded, start_at}

#ifdef COMPUTE
#import bevy_lean_deferred::effects::ambient_occlusion::bindings::sparse_depth_texture
#import bevy_lean_deferred::effects::ambient_occlusion::lattice::{corner_of_lattice, first_of_lattice}
#import bevy_lean_deferred::rounding::{rounded_to_fours, rounder_to_fours}
#endif

#ifdef SHADING_NORMALS
#import bevy_lean_deferred::effects::ambient_occlusion::bindings::normal_texture
#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, unpack_normal}
#endif

/// Slices through a pixel, and samples on either side of each. Compiled in, so that loops unroll.
const SLICES: u32 = #{SLICES}u;
const STEPS: u32 = #{STEPS}u;

#ifdef COMPUTE
/// Distance in pixels from which samples may be from the pixel's lattice. Those are up to two pixels away from where they should be along
/// each axis.
const LEAST_SPARSE: f32 = 8.0;

/// The second sample as `March::steps` has it, where the pattern brings it nearest.
const SECOND: f32 = 1.125 * 0.5 / f32(STEPS);
/// Longer side of a direction's radius on screen, in pixels, at which that sample is `LEAST_SPARSE` away.
const SPARSE_RADIUS: f32 = LEAST_SPARSE / (2.0 * SECOND * SECOND + SECOND);
#endif

/// Per-pixel terms of the march, and the direction and steps of the current slice.
struct March {
    pixel: vec2<f32>,
    depth: f32,
    /// Homogeneous w of the pixel. Like `of_w`, scaled so that distance² / w² is the falloff of a sample's weight.
    w: f32,
    /// Change per pixel to the right, per pixel downwards and per unit of depth: of w; and, times w at the sample, of the distance
    /// towards the viewer and of the height above the surface.
    of_w: vec3<f32>,
    of_viewer: vec3<f32>,
    of_surface: vec3<f32>,
#ifndef PROJECTION_PERSPECTIVE
    /// Coefficients of x², y² and xy in the squared length of a screen step.
    of_squares: vec3<f32>,
    /// Coefficients that a depth difference adds to it: with x, with y, and squared.
    of_depth: vec3<f32>,
#endif
    /// On screen; its longer side is one pixel.
    direction: vec2<f32>,
    /// Step x is `steps.x` x² + `steps.y` x pixels away on both sides: samples are denser near the pixel.
    steps: vec2<f32>,
    /// Jitter of the first step, 0 to 1 steps.
    offset: f32,
#ifdef THIN
    /// Binary logarithm of the factor by which horizons sink per pixel of distance.
    decay: f32,
#endif
}

/// Sets all but what each slice has of its own: `direction` and what follows it.
fn march_from(
    pixel: vec2<i32>,
    ray: vec2<f32>,
    depth: f32,
    position: vec3<f32>,
    to_viewer: vec3<f32>,
    geometric: vec3<f32>,
    excess: f32,
) -> March {
    let of_steps = homogeneous_steps(view.view_from_pixel, position);
    let to_right = of_steps[0].xyz;
    let down = of_steps[1].xyz;
    let metre = 1.0 / (view.decline * excess);
    var march: March;
    march.pixel = vec2<f32>(pixel);
    march.depth = depth;
    march.w = w_at(view.view_from_pixel, ray, depth) * metre;
    march.of_w = metre * vec3(of_steps[0].w, of_steps[1].w, of_steps[2].w);
    march.of_viewer = vec4(to_viewer, 0.0) * of_steps;
    march.of_surface = vec4(geometric, 0.0) * of_steps;
#ifndef PROJECTION_PERSPECTIVE
    march.of_squares = vec3(dot(to_right, to_right), dot(down, down), 2.0 * dot(to_right, down));
    let nearer = of_steps[2].xyz;
    march.of_depth = vec3(2.0 * dot(to_right, nearer), 2.0 * dot(down, nearer), dot(nearer, nearer));
#endif
    return march;
}

/// Increments of a screen step. A step to the opposite side negates the first four.
struct Step {
    w: f32,
    to_viewer: f32,
    above_surface: f32,
    with_depth: f32,
    squared: f32,
#ifdef THIN
    /// Share of a horizon that remains after the step.
    kept: f32,
#endif
}

fn step_of(march: March, pixels: vec2<f32>) -> Step {
    var step: Step;
    step.w = dot(march.of_w.xy, pixels);
    step.to_viewer = dot(march.of_viewer.xy, pixels);
    step.above_surface = dot(march.of_surface.xy, pixels);
#ifdef PROJECTION_PERSPECTIVE
    // Of the part perpendicular to the viewer. Without coefficients, which would take three registers through the march.
    let across = ray_step(view.view_from_pixel, pixels);
    step.squared = dot(across, across) - step.to_viewer * step.to_viewer;
#else
    let squares = march.of_squares;
    step.squared = (squares.x * pixels.x + squares.z * pixels.y) * pixels.x + squares.y * pixels.y * pixels.y;
    step.with_depth = dot(march.of_depth.xy, pixels);
#endif
    return step;
}

/// Depths at a step to one side of the pixel, and at the same step to the other. Those off-screen may be anything: `higher` ignores them.
struct Pair {
    step: vec2<f32>,
    ahead: f32,
    back: f32,
}

/// The pixel as the start of steps. It is made of `March` once per slice: that takes fewer registers than keeping it.
struct Dense {
    start: Start,
    /// Twice the pixel's texture coordinates. Minus those of one sample, they are those of the opposite one.
    twice: vec2<i32>,
}

fn dense_of(march: March) -> Dense {
    let pixel = vec2<i32>(march.pixel);
    let origin = vec2<i32>(view.viewport_origin);
    return Dense(start_at(pixel, origin), 2 * (pixel + origin));
}

/// The pair of pixels nearest to a distance.
fn pair_at(march: March, dense: Dense, distance: f32) -> Pair {
    let ahead = rounded(dense.start, march.direction, distance);
    let depth_ahead = textureLoad(depth_texture, ahead.place, 0);
    let depth_back = textureLoad(depth_texture, dense.twice - ahead.place, 0);
    return Pair(ahead.step, depth_ahead, depth_back);
}

#ifdef COMPUTE
/// The pixel as the start of steps on its lattice.
struct Sparse {
    /// Pixel relative to the lattice's first.
    pixel: vec2<f32>,
    /// Texel of the lattice's first pixel.
    corner: vec2<i32>,
    /// As `Dense::twice`, in texels of sparse depth.
    twice: vec2<i32>,
    rounder: f32,
}

fn sparse_of(march: March, parity: vec2<i32>) -> Sparse {
    let size = vec2<i32>(view.viewport_size);
    let pixel = vec2<i32>(march.pixel) - first_of_lattice(parity);
    let corner = corner_of_lattice(parity, size);
    let twice = 2 * corner + (pixel >> vec2(1u));
    // The size is positive.
    return Sparse(vec2<f32>(pixel), corner, twice, rounder_to_fours(size.x >> 31u));
}

/// The pair of the lattice's pixels nearest to a distance.
fn sparse_pair_at(march: March, sparse: Sparse, distance: f32) -> Pair {
    let ahead = rounded_to_fours(sparse.pixel, march.direction, distance, sparse.rounder);
    let place = ahead.place + sparse.corner;
    let depth_ahead = textureLoad(sparse_depth_texture, place, 0).r;
    let depth_back = textureLoad(sparse_depth_texture, sparse.twice - place, 0).r;
    return Pair(ahead.step, depth_ahead, depth_back);
}
#endif

/// Highest horizon on one `side` (1 or -1) after a sample of this depth. `highest` and the result are relative to `base`.
fn higher(march: March, step: Step, side: f32, depth: f32, is_seen: bool, base: f32, highest: f32) -> f32 {
    let nearer = depth - march.depth;
    let to_viewer = side * step.to_viewer + march.of_viewer.z * nearer;
    let above_surface = side * step.above_surface + march.of_surface.z * nearer;
    // `to_viewer`, `above_surface` and the distance share a factor of w, which cancels out.
#ifdef PROJECTION_PERSPECTIVE
    let distance_squared = step.squared + to_viewer * to_viewer;
    let inverse_w = 1.0 / (march.w + march.of_w.z * nearer);
#else
    let distance_squared = step.squared + nearer * (side * step.with_depth + march.of_depth.z * nearer);
    let inverse_w = 1.0 / (march.w + side * step.w + march.of_w.z * nearer);
#endif
    let inverse_distance = inverseSqrt(distance_squared);
    let weight = saturate(view.inverse_falloff - distance_squared * inverse_w * inverse_w);
    let height = (to_viewer * inverse_distance - base) * weight;
    // The sky is no occluder, though projections with a far plane place it there.
    let counts = above_surface * inverse_distance > view.sin_bias && depth > 0.0 && is_seen;
#ifdef THIN
    let counted = select(0.0, height, counts);
    // Off-screen samples must not lower the horizon, as samples behind thin surfaces do.
    return select(highest, max(counted, mix(counted, highest, step.kept)), is_seen);
#else
    return select(highest, max(highest, height), counts);
#endif
}

/// Numbers of the view's pixels on both sides of a pixel, along each axis.
struct Room {
    ahead: vec2<f32>,
    back: vec2<f32>,
}

fn room_of(march: March) -> Room {
    let behind = vec2<f32>(view.viewport_size) - 1.0 - march.pixel;
    let is_right = march.direction > vec2(0.0);
    return Room(select(march.pixel, behind, is_right), select(behind, march.pixel, is_right));
}

/// Highest horizons on both sides after a pair of samples, relative to `bases`. `gap`: distance from the last pair, in pixels.
fn highest_after(march: March, room: Room, pair: Pair, gap: f32, bases: vec2<f32>, highest: vec2<f32>) -> vec2<f32> {
    let pixels = abs(pair.step);
    var step = step_of(march, pair.step);
#ifdef THIN
    step.kept = exp2(-march.decay * gap);
#endif
    return vec2(
        higher(march, step, 1.0, pair.ahead, all(pixels <= room.ahead), bases.x, highest.x),
        higher(march, step, -1.0, pair.back, all(pixels <= room.back), bases.y, highest.y),
    );
}

/// Cosines of the horizon angles to the viewer on both sides; `bases` where no sample is above the surface.
/// Samples come in pairs at equal distances on both sides, which share all terms but their depths. Off-screen samples are read too,
/// so that no branch keeps the reads from being issued at once. If `is_sparse`, all samples but the first are from the pixel's lattice.
fn horizons(march: March, parity: vec2<i32>, bases: vec2<f32>, is_sparse: bool) -> vec2<f32> {
    let room = room_of(march);
    let dense = dense_of(march);
#ifdef COMPUTE
    let sparse = sparse_of(march, parity);
#endif
    // Distance of the first sample, and its growth per sample. Both are at least a pixel: no sample repeats the pixel or the last sample.
    let offset = march.offset;
    let at_first = max((march.steps.x * offset + march.steps.y) * offset, 1.0);
    let growth = max(2.0 * march.steps.x * offset + march.steps.y, 1.0);
    // Before the loop, whose samples then are all of one texture: it unrolls only while it is short.
    var highest = highest_after(march, room, pair_at(march, dense, at_first), at_first, bases, vec2(0.0));
    var last = at_first;
    for (var i = 1u; i < STEPS; i++) {
        let x = f32(i);
        let distance = at_first + x * growth + x * x * march.steps.x;
        var pair: Pair;
#ifdef COMPUTE
        if is_sparse {
            pair = sparse_pair_at(march, sparse, distance);
        } else {
            pair = pair_at(march, dense, distance);
        }
#else
        pair = pair_at(march, dense, distance);
#endif
        highest = highest_after(march, room, pair, distance - last, bases, highest);
        last = distance;
    }
    return bases + highest;
}

/// Rotates by an angle; both are given as cosine and sine.
fn turned(rotation: vec2<f32>, angle: vec2<f32>) -> vec2<f32> {
    return vec2(
        rotation.x * angle.x - rotation.y * angle.y,
        rotation.x * angle.y + rotation.y * angle.x,
    );
}

/// Cosine-weighted occlusion of a pixel, 0 to 1, from the pattern's slices of `phase` 0 to 3. `parity`: 1 for odd coordinates.
fn hbao(phase: u32, texel: vec2<u32>, pixel: vec2<i32>, parity: vec2<i32>, depth: f32, around: DepthsAround) -> f32 {
    let center = vec2<f32>(pixel) + 0.5;
    let ray = ray_at(view.view_from_pixel, center);
    let position = position_on(view.view_from_pixel, ray, depth);
    let radius = radius_at(position, depth);
    // Also true of NaN.
    if !(largest_side(radius.pixels) > 1.0) {
        return 0.0;
    }
    let to_viewer = direction_to_viewer(position);
    var geometric = geometric_normal(
        view.view_from_pixel, view.pixels_per_ray, center, position, to_viewer, depth, around,
    );
    var normal = geometric;
#ifdef SHADING_NORMALS
    let word = textureLoad(normal_texture, vec2<i32>(view.viewport_origin) + pixel, 0).r;
    if word != NO_GEOMETRY {
        normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
        // At silhouettes, depth may belong to another surface. No shading normal leans that far from its surface.
        if dot(normal, geometric) < 0.5 {
            geometric = normal;
        }
    }
#endif
    var march = march_from(pixel, ray, depth, position, to_viewer, geometric, radius.excess);

    // Steps vary over 4×4 texels; with a wide filter, directions do too. A narrow filter leaves a fine dither of that pattern, not
    // stripes.
    let quad = (texel >> vec2(1u)) & vec2(1u);
    let block = quad.x + 2u * quad.y;
    var rotation = view.rotations[phase].xy;
    var offset = 0.125 + 0.25 * f32(phase ^ block) + view.turn;
    if view.has_wide_pattern != 0u {
        rotation = turned(rotation, view.rotations[block].zw);
        offset = 0.125 + 0.25 * f32(phase + block) + 0.0625 * f32(block) + view.turn;
    }

    // The first slice is along the first axis. Terms along both axes, of which the slices need few, take fewer registers than vectors.
    let basis = tangents(to_viewer) * mat2x2(rotation, vec2(-rotation.y, rotation.x));
    rotation = vec2(1.0, 0.0);
    let slope = ray_slope(view.view_from_pixel, ray, position);
    let on_tangents = mat2x2(
        radius.pixels * direction_on_screen(slope, basis[0]), radius.pixels * direction_on_screen(slope, basis[1]),
    );
    let normal_on_tangents = normal * basis;
    let normal_to_viewer = dot(normal, to_viewer);
    let geometric_on_tangents = geometric * basis;
    let geometric_to_viewer = dot(geometric, to_viewer);
    var occlusion = 0.0;
    for (var slice = 0u; slice < SLICES; slice++) {
        // Even in angle about the view direction, not on screen: perspective is exact off-centre too.
        let lobe = slice_normal(vec2(normal_to_viewer, dot(normal_on_tangents, rotation)));
        let surface = slice_normal(vec2(geometric_to_viewer, dot(geometric_on_tangents, rotation)));
        let on_screen = on_tangents * rotation;
        rotation = turned(rotation, view.slice_rotation);
        // Horizons of the surface itself.
        let bases = vec2(-surface.sine, surface.sine);

        let longer_side = largest_side(on_screen);
        march.direction = on_screen / longer_side;
        let part = 0.5 / f32(STEPS);
        march.steps = longer_side * part * vec2(2.0 * part, 1.0);
        march.offset = fract(offset + 0.618 * f32(slice));
#ifdef THIN
        march.decay = view.decay / (radius.excess * longer_side);
#endif
#ifdef COMPUTE
        var found: vec2<f32>;
        // Two calls with constants compile to marches without branches.
        if longer_side < SPARSE_RADIUS {
            found = horizons(march, parity, bases, false);
        } else {
            found = horizons(march, parity, bases, true);
        }
#else
        let found = horizons(march, parity, bases, false);
#endif
        occlusion += side_occlusion(lobe, bases.x, found.x, 1.0) + side_occlusion(lobe, bases.y, found.y, -1.0);
    }
    return occlusion / f32(SLICES);
}
