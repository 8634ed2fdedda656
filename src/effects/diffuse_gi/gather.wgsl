// Gathers the light on each texel from other surfaces, and the share of the hemisphere that these cover. Along slices of the
// picture, each surface above all previous ones covers an arc of the hemisphere and fills it with its light (Mayaux 2018,
// "Horizon-based indirect lighting"). Cosine-weighted in closed form, like ambient occlusion.
#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, is_finite, unpack_normal}
#import bevy_lean_deferred::gbuffer::layout::light::{integer_logarithm, power_of_two, unpack_mantissas, unpack_scale}
#import bevy_lean_deferred::horizon::{PI, SliceNormal, arc, lean_of, sine_of_lean, tangents}
#import bevy_lean_deferred::pattern::rotation_index
#import bevy_lean_deferred::reconstruction::normal_from_depth::{DepthView, depths_around, geometric_normal}
#import bevy_lean_deferred::reconstruction::position::{
    direction_on_screen, homogeneous_steps, position_on, ray_at, ray_slope, ray_step, w_at,
}
#import bevy_lean_deferred::rounding::{Start, place_after, rounded, start_at, start_of}
#import bevy_lean_deferred::effects::diffuse_gi::bindings::{
    depth_texture, edge_step, gathered_output, levels, normal_texture, view,
}
#import bevy_lean_deferred::effects::diffuse_gi::entry::{unpack_depth, unpack_known, unpack_pixel}
#import bevy_lean_deferred::tiles::{pixel_in_view, pixel_of_square}

const SLICES: u32 = #{SLICES}u;
const STEPS: u32 = #{STEPS}u;
/// Index of the coarsest level.
const LAST_LEVEL: i32 = 3;
/// Jitter of a slice after that of the last one, in steps: about the golden ratio.
const SLICE_OFFSET: f32 = 0.618;
/// Keeps the sine of a normal across the slice finite.
const SMALLEST_SQUARE: f32 = 1e-12;

/// Surface that receives the light. Vectors from it to others are homogeneous: times w, over the side of a texel in pixels.
struct Receiver {
    texel: Start,
    depth: f32,
    /// Change per texel to the right, per texel downwards and per unit of depth: of the distance towards the viewer, and of the height
    /// above the surface.
    of_viewer: vec3<f32>,
    of_surface: vec3<f32>,
    /// w over the side of a texel. Scaled so that distance² / w² is the falloff of a surface's weight.
    w: f32,
#ifdef PROJECTION_PERSPECTIVE
    /// Change of w per unit of depth.
    of_w: f32,
#else
    /// Changes of the vector, and of w.
    of_steps: mat3x4<f32>,
#endif
}

/// Side of a texel in pixels. From bits: a conversion would take a vector register, though all invocations have the same value.
fn texel_side() -> f32 {
    return power_of_two(view.divisor - 1);
}

fn receiver_at(
    texel: vec2<i32>,
    ray: vec2<f32>,
    depth: f32,
    position: vec3<f32>,
    to_viewer: vec3<f32>,
    geometric: vec3<f32>,
    metres: f32,
) -> Receiver {
    var of_steps = homogeneous_steps(view.view_from_pixel, position);
    // Steps of a pixel become those of a texel by the division of all others.
    of_steps[2] /= texel_side();
    var receiver: Receiver;
    receiver.texel = start_at(texel, vec2(0));
    receiver.depth = depth;
    receiver.of_viewer = vec4(to_viewer, 0.0) * of_steps;
    receiver.of_surface = vec4(geometric, 0.0) * of_steps;
    let scale = metres * inverseSqrt(view.inverse_falloff);
    receiver.w = w_at(view.view_from_pixel, ray, depth) * scale / texel_side();
#ifdef PROJECTION_PERSPECTIVE
    receiver.of_w = of_steps[2].w * scale;
#else
    let only_w = vec4(1.0, 1.0, 1.0, scale);
    receiver.of_steps = mat3x4(of_steps[0] * only_w, of_steps[1] * only_w, of_steps[2] * only_w);
#endif
    return receiver;
}

/// Horizon cosine of the surface of this depth, `texels` from the receiver; `base` if it does not count.
fn height_of(receiver: Receiver, base: f32, texels: vec2<f32>, depth: f32) -> f32 {
    let nearer = depth - receiver.depth;
    let step_to_viewer = dot(receiver.of_viewer.xy, texels);
    let to_viewer = step_to_viewer + receiver.of_viewer.z * nearer;
    let above_surface = dot(receiver.of_surface, vec3(texels, nearer));
#ifdef PROJECTION_PERSPECTIVE
    // Depth changes `to_viewer` only, so the part across is that of the step.
    let step = ray_step(view.view_from_pixel, texels);
    let distance_squared = dot(step, step) - step_to_viewer * step_to_viewer + to_viewer * to_viewer;
    let w = receiver.w + receiver.of_w * nearer;
#else
    let delta = receiver.of_steps * vec3(texels, nearer);
    let distance_squared = dot(delta.xyz, delta.xyz);
    let w = receiver.w + delta.w;
#endif
    let inverse_distance = inverseSqrt(distance_squared);
    let inverse_w = 1.0 / w;
    let weight = saturate(view.inverse_falloff - distance_squared * inverse_w * inverse_w);
    let counts = above_surface * inverse_distance > view.sin_bias;
    return select(base, mix(base, to_viewer * inverse_distance, weight), counts);
}

/// One side of a slice.
struct Side {
    /// 1 or -1.
    sign: f32,
    /// Texels per unit of distance; the longer side is one texel.
    direction: vec2<f32>,
    /// Distance to the end.
    reach: f32,
    /// Jitter of the samples, 0 to 1 steps.
    offset: f32,
    /// Horizon cosine of the receiver itself.
    base: f32,
    /// Cosine and sine of the shading normal's angle to the viewer, times the length of its projection into the slice.
    lobe: SliceNormal,
    /// The sine alone.
    lobe_sine: f32,
}

/// `height_of` the surface of this depth, `texels` from the receiver, continued by half of the `gap` to the next sample: the surface
/// ends somewhere between the two. Two depths define a plane, because depth is affine on screen. Steep surfaces are continued less: at
/// its limb a ball ends. `edge`: depth step that separates neighbouring texels.
fn height_further_out(receiver: Receiver, side: Side, texels: vec2<f32>, depth: f32, edge: f32, gap: f32) -> f32 {
    let step = round(side.direction);
    let place = place_after(receiver.texel, texels + step);
    let inside = clamp(place, vec2(0), vec2<i32>(view.texture_size) - 1);
    let beside = unpack_depth(textureLoad(levels, inside, 0).r);
    let slope = beside - depth;
    let share = select(0.0, saturate(1.5 - 2.0 * abs(slope) / edge), beside > 0.0);
    let way = 0.5 * gap * share;
    return height_of(receiver, side.base, texels + step * way, max(depth + slope * way, 0.5 * depth));
}

/// Words of the level that holds the light of a surface averaged over about as many texels as there are to the next sample. `words`:
/// of the `texel` itself, which has this `depth`.
fn words_of_light(texel: vec2<i32>, words: vec2<u32>, depth: f32, edge: f32, gap: f32) -> vec2<u32> {
    // Texels as large as half of the gap.
    let level = clamp(integer_logarithm(gap) - 1, 0, LAST_LEVEL);
    if level == 0 {
        return words;
    }
    let coarse = textureLoad(levels, texel >> vec2(u32(level)), level).rg;
    let is_surface = abs(unpack_depth(coarse.x) - depth) < edge * power_of_two(level);
    return select(words, coarse, is_surface);
}

/// Adds the light from one side of a slice to `found`, and to its w the part of the hemisphere that the surfaces there cover. Those of
/// unknown light count in neither: the environment that they hide stays in their place.
fn march(receiver: Receiver, side: Side, found: vec4<f32>) -> vec4<f32> {
    var sum = found;
    var highest = side.base;
    // Light from below the shading normal's own horizon does not count.
    let lowest = -side.sign * side.lobe_sine;
    // Arc up to the highest surface so far.
    var open = arc(side.lobe, max(highest, lowest), side.sign);
    var end_of_step = side.offset;
    for (var i = 0u; i < STEPS; i++) {
        end_of_step += 1.0;
        // Denser near the texel; no sample repeats the texel or the last sample.
        let t = (end_of_step - 1.0) / f32(STEPS);
        let distance = max(side.reach * t * t, floor(end_of_step));
        let sample = rounded(receiver.texel, side.direction, distance);
        // Negative coordinates wrap to values above any size.
        if any(bitcast<vec2<u32>>(sample.place) >= view.texture_size) {
            break;
        }
        let words = textureLoad(levels, sample.place, 0).rg;
        // The sky is no surface.
        if words.x == 0u {
            continue;
        }
        let depth = unpack_depth(words.x);
        let height = height_of(receiver, side.base, sample.step, depth);
        if height > highest {
            // Difference of the next t² from this one.
            let gap = max(side.reach * (2.0 * end_of_step - 1.0) / f32(STEPS * STEPS), 1.0);
            let edge = edge_step(depth, texel_side());
            // Not `sample.place`: it would be live up to here.
            let texel = place_after(receiver.texel, sample.step);
            let light = words_of_light(texel, words, depth, edge, gap);
            highest = max(height, height_further_out(receiver, side, sample.step, depth, edge, gap));
            let still_open = min(arc(side.lobe, max(highest, lowest), side.sign), open);
            let known = unpack_known(light.x) * (open - still_open);
            sum += vec4(unpack_mantissas(light.y) * (unpack_scale(light.y) * known), known);
            open = still_open;
        }
    }
    return sum;
}

/// A texel and what was gathered there.
struct Gathered {
    texel: vec2<i32>,
    light: vec4<f32>,
}

fn gather(texel: vec2<i32>, place: vec2<u32>) -> Gathered {
    let shown = textureLoad(levels, texel, 0).r;
    let depth = unpack_depth(shown);
    // Without a last frame, no light is known.
    if depth == 0.0 || view.exposure_ratio == 0.0 {
        return Gathered(texel, vec4(0.0));
    }
    let pixel = texel * view.divisor + pixel_of_square(unpack_pixel(shown));
    let center = vec2<f32>(pixel) + 0.5;
    let ray = ray_at(view.view_from_pixel, center);
    let position = position_on(view.view_from_pixel, ray, depth);
#ifdef PROJECTION_ORTHOGRAPHIC
    let to_viewer = vec3(0.0, 0.0, 1.0);
    var pixels = view.radius * view.pixels_per_metre;
#else
    let to_viewer = normalize(-position);
    var pixels = view.radius * view.pixels_per_metre / max(-position.z, 1e-6);
#endif
    let shrink = min(view.largest_radius_in_pixels / max(abs(pixels.x), abs(pixels.y)), 1.0);
    pixels *= shrink;
    let texels = pixels / texel_side();
    // Also true of NaN.
    if !(max(abs(texels.x), abs(texels.y)) > 1.0) {
        return Gathered(texel, vec4(0.0));
    }

    let in_depth = DepthView(vec2<i32>(view.viewport_origin), vec2<i32>(view.viewport_size));
    var geometric = geometric_normal(
        view.view_from_pixel, view.pixels_per_ray, center, position, to_viewer, depth,
        depths_around(depth_texture, in_depth, pixel, false),
    );
    var normal = geometric;
    let word = textureLoad(normal_texture, vec2<i32>(view.viewport_origin) + pixel, 0).r;
    if word != NO_GEOMETRY {
        normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
        // At silhouettes, depth may belong to another surface. No shading normal leans that far from its surface.
        if dot(normal, geometric) < 0.5 {
            geometric = normal;
        }
    }
    let receiver = receiver_at(texel, ray, depth, position, to_viewer, geometric, view.radius * shrink);

    // Even in angle about the view direction, not on screen: perspective is exact off-centre too.
    // Of the angles between those of a block of 4×4 texels, each block has a quarter: 2×2 blocks have all.
    let turn_index = 4u * rotation_index(place) + (rotation_index(vec2<u32>(texel) / 4u) >> 2u);
    let turn = PI * (f32(turn_index) + view.turn) / (64.0 * f32(SLICES));
    // The first slice is along the first axis. Terms along both axes, of which the slices need few, take fewer registers than vectors.
    let basis = tangents(to_viewer) * mat2x2(cos(turn), sin(turn), -sin(turn), cos(turn));
    let slope = ray_slope(view.view_from_pixel, ray, position);
    let on_tangents = mat2x2(
        texels * direction_on_screen(slope, basis[0]), texels * direction_on_screen(slope, basis[1]),
    );
    let normal_on_tangents = normal * basis;
    let normal_to_viewer = dot(normal, to_viewer);
    let lean = lean_of(geometric * basis, dot(geometric, to_viewer));
    var side: Side;
    // Steps are jittered too, in another order than directions.
    var offset = fract((f32((turn_index * 39u) & 63u) + 0.5) / 64.0 + view.turn);
    var found = vec4(0.0);
    for (var slice = 0u; slice < SLICES; slice++) {
        let angle = PI * f32(slice) / f32(SLICES);
        let rotation = vec2(cos(angle), sin(angle));
        let along_slice = dot(normal_on_tangents, rotation);
        // `arc` is linear in the normal, so its cosine and sine may have the length of the projection.
        side.lobe = SliceNormal(1.0, normal_to_viewer, along_slice);
        let squared = normal_to_viewer * normal_to_viewer + along_slice * along_slice;
        side.lobe_sine = along_slice * inverseSqrt(max(squared, SMALLEST_SQUARE));
        let surface_sine = sine_of_lean(dot(lean, rotation));
        let on_screen = on_tangents * rotation;
        side.reach = max(abs(on_screen.x), abs(on_screen.y));

        side.sign = 1.0;
        side.base = -surface_sine;
        side.direction = on_screen / side.reach;
        side.offset = offset;
        found = march(receiver, side, found);

        side.sign = -1.0;
        side.base = surface_sine;
        side.direction = -side.direction;
        side.offset = fract(offset + 0.5);
        found = march(receiver, side, found);
        offset = fract(offset + SLICE_OFFSET);
    }
    found /= f32(SLICES);
    // Not clamped: a single slice may exceed its share of the hemisphere, and another fall below it.
    let is_number = is_finite(found.r + found.g + found.b + found.a);
    let light = select(vec4(0.0), vec4(found.rgb * view.intensity, found.a), is_number);
    // Not `texel`: it would be live up to here.
    return Gathered(start_of(receiver.texel), light);
}

/// Each workgroup gathers the texels of 32×32 that are alike in a block of the pattern. Their directions are nearly the same, so that
/// the invocations of a subgroup march in parallel.
@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let phase = workgroup.x & 15u;
    let place = vec2(phase & 3u, phase >> 2u);
    let tile = vec2(workgroup.x >> 4u, workgroup.y);
    let texel = 4u * pixel_in_view(tile, invocation) + place;
    if all(texel < view.texture_size) {
        let gathered = gather(vec2<i32>(texel), place);
        textureStore(gathered_output, gathered.texel, gathered.light);
    }
}
