// Traces a ray of the lobe of each texel's surface, a different one for each of 4×4 texels, through the depth of this frame into
// the light of the last one. Rays of smooth surfaces take the mirror's direction up to where the lobe is two texels wide, and scatter
// from there: what is nearer is exact, and blurred by the spatial filter alone, without noise.
#import bevy_lean_deferred::ggx::sample_lobe
#import bevy_lean_deferred::gbuffer::layout::is_finite
#import bevy_lean_deferred::horizon::tangents
#import bevy_lean_deferred::pattern::rotation_index
#import bevy_lean_deferred::effects::reflections::bindings::{
    CHANGES, MOVES, depth_in_view, hits_output, pack_begin, pack_hit, place_in_texel, rays_output, surfaces_output,
    to_viewer, view, view_position,
}
#import bevy_lean_deferred::effects::reflections::lobes::shift_of
#import bevy_lean_deferred::effects::reflections::mirrored_light::mirrored_light
#import bevy_lean_deferred::effects::reflections::ray::{RayHit, MarchState, hit_at, ray_on_screen}
#import bevy_lean_deferred::effects::reflections::rough_march
#import bevy_lean_deferred::effects::reflections::smooth_march::{Path, march as march_smooth}
#import bevy_lean_deferred::effects::reflections::surface::{
    Mirror, ROUGH, mirror_of, moves_itself, normal_word_at, rotated, smoothness, with_roughness,
}
#import bevy_lean_deferred::screen_ray::{Ray, metres_at, rim_fade}
#import bevy_lean_deferred::tiles::pixel_in_view

/// Rays that form a lobe together: those of 4×4 texels.
const RAYS: u32 = 16u;

/// Least growth of a ray's segments with its length, so that most rays leave the picture before their segments are used up.
const LEAST_GROWTH: f32 = 0.03;

/// Radius in texels of a smooth surface's lobe up to which its rays take the mirror's direction.
const TOGETHER: f32 = 2.0;

/// Mirror from which a texel's ray starts.
struct Begin {
    /// In pixels, and depth; 0 without a ray.
    start: vec3<f32>,
    mirror: Mirror,
    /// Normal word, and `start` as packed by `pack_begin`; 0 without a ray.
    surface: vec2<u32>,
}

/// Result of a ray.
struct TraceResult {
    /// Light and confidence.
    light: vec4<f32>,
    /// Packed by `pack_hit`.
    hit: u32,
}

/// Light at a ray's hit.
struct HitLight {
    /// Light and confidence.
    light: vec4<f32>,
    /// Distance to the mirror image, as packed by `pack_hit`; 0 without light.
    image: f32,
    /// Share of the light that the last frame showed.
    known: f32,
    /// `MOVES` for a surface that moves on its own, or 0.
    moves: u32,
}

/// Number of a texel's ray among the sixteen. Those of smooth surfaces move by two texels from frame to frame, so that those of one texel
/// cover a quarter turn: with a single azimuth, edges would be hatched.
fn ray_of(texel: vec2<u32>, is_rough: bool) -> u32 {
    let moved = select(2u * vec2(view.phase & 1u, view.phase >> 1u), vec2(0u), is_rough);
    return rotation_index((texel + moved) & vec2(3u));
}

/// Two numbers from 0 to 1 per ray (Hammersley 1960, "Monte Carlo methods for solving multivariable problems"), shifted.
fn numbers_of(ray: u32, shift: vec2<f32>) -> vec2<f32> {
    let pair = (vec2(f32(ray), f32(reverseBits(ray) >> 28u)) + 0.5) / f32(RAYS);
    return fract(pair + shift + view.turn * vec2(1.0, 0.754877));
}

/// True for a surface with a mirror of some smoothness.
fn reflects(depth: f32, mirror: Mirror) -> bool {
    return depth > 0.0 && smoothness(mirror.roughness) > 0.0;
}

/// Metres up to which the rays of a smooth surface take the mirror's direction.
fn metres_together(alpha: f32, to_mirror: f32) -> f32 {
    let wide = 2.0 * alpha * abs(view.pixels_per_metre.y);
    let most = TOGETHER * f32(view.divisor);
#ifdef PROJECTION_ORTHOGRAPHIC
    return most / max(wide, 1e-9);
#else
    // The lobe's radius on screen approaches `wide`.
    return select(1e9, most * to_mirror / (wide - most), wide > most);
#endif
}

/// The ray starts at the first of four pixels that reflects: a thin mirror may cover others only.
fn begin_at(texel: vec2<i32>) -> Begin {
    var begin: Begin;
    if view.exposure_ratio == 0.0 {
        return begin;
    }
    let first = texel * view.divisor;
    for (var i = 0; i < 4; i++) {
        let pixel = min(first + place_in_texel(i), vec2<i32>(view.viewport_size) - 1);
        let depth = depth_in_view(pixel);
        let word = normal_word_at(pixel);
        let mirror = mirror_of(pixel, word);
        if reflects(depth, mirror) {
            let surface = vec2(with_roughness(word, mirror.roughness), pack_begin(depth, i));
            return Begin(vec3(vec2<f32>(pixel) + 0.5, depth), mirror, surface);
        }
        if view.divisor == 1 {
            break;
        }
    }
    return begin;
}

fn trace(start: vec3<f32>, mirror: Mirror, texel: vec2<u32>) -> TraceResult {
    let is_rough = mirror.roughness > ROUGH;
    let turn = ray_of(texel, is_rough);
    let position = view_position(start.xy, start.z);
    let to_mirror = length(position);
    let V = to_viewer(position);
    let normal = rotated(mirror.normal);
    let basis = tangents(normal);
    // Shading normals may lean away from the viewer.
    let local = normalize(vec3(V * basis, max(dot(V, normal), 1e-3)));
    let alpha = mirror.roughness * mirror.roughness;
    let sample = sample_lobe(local, alpha, numbers_of(turn, shift_of(view.phase, is_rough)));
    let scattered = basis * sample.direction.xy + normal * sample.direction.z;
    let direction = select(basis * -local.xy + normal * local.z, scattered, is_rough);
    var path = Path(ray_on_screen(start, position, direction, vec2<f32>(view.viewport_size)), direction, is_rough);
    var hit: RayHit;
    // Segments begin in the middle of the next pixel.
    var state = MarchState(1.0, true, 0.0);
    let together = metres_together(alpha, to_mirror);
    if !is_rough {
        hit = march_smooth(&path, scattered, together, view.smooth_steps, &state);
    }
    let ray = path.ray;
    let weight = select(1.0, sample.weight, path.is_scattered);
    var seen = HitLight(vec4(0.0), 0.0, 1.0, 0u);
    if weight != 0.0 {
        // Rays of rough surfaces march in segments from the start. Smooth ones whose steps are used up continue in segments: they are
        // few, but all others would wait for them.
        if !hit.is_hit && state.u < ray.end {
            // Differs from that of neighbouring rays, and is the same in each frame, because not all of these rays scatter.
            let phase = fract(f32(rotation_index(texel & vec2(3u))) * 0.618034);
            let growth = max(view.growth * alpha, LEAST_GROWTH);
            hit = rough_march::march(ray, path.direction, growth, phase, view.rough_segments, !is_rough, &state);
        }
        if hit.is_hit {
            // Metres from the mirror to where the ray scatters.
            let begin = select(0.0, together, path.is_scattered && !is_rough);
            seen = light_at(ray, hit, state.span, to_mirror, begin, alpha, is_rough, path.is_scattered, sample.density);
        }
    }
    let bits = select(0u, CHANGES, path.is_scattered) | seen.moves;
    return TraceResult(seen.light, pack_hit(seen.image, weight * seen.known, bits));
}

/// Light at the hit of a ray that begins `begin` metres beyond its mirror, where it scatters, if it does. That is `to_mirror` metres away,
/// and has the squared roughness `alpha`. `density`: of scattered rays in this direction.
fn light_at(
    ray: Ray,
    rough_hit: RayHit,
    span: f32,
    to_mirror: f32,
    begin: f32,
    alpha: f32,
    is_rough: bool,
    is_scattered: bool,
    density: f32,
) -> HitLight {
    let nothing = HitLight(vec4(0.0), 0.0, 1.0, 0u);
    // Here, where the rays of a subgroup have converged again.
    let hit = hit_at(ray, vec2<i32>(rough_hit.place.xy), rough_hit.place.z, rough_hit.u, span, rough_hit.certainty);
    if hit.certainty == 0.0 {
        return nothing;
    }
    let hit_position = view_position(hit.place.xy, hit.place.z);
    let metres = begin + metres_at(ray, hit.u);
    // As wide as this ray's share of the lobe, and, where rays are together, up to a texel.
    let scale = abs(view.pixels_per_metre.y);
#ifdef PROJECTION_ORTHOGRAPHIC
    let scale_at_hit = scale;
#else
    let scale_at_hit = scale / max(-hit_position.z, 1e-6);
#endif
    let wide = (metres - begin) * scale_at_hit;
    let share = select(0.0, wide * wide / (f32(RAYS) * density), is_scattered);
    // Unsigned, and the size below signed, so that they are converted here: those before the march would be in registers throughout.
    let texel_wide = min(4.0 * alpha * metres * scale_at_hit, f32(u32(view.divisor)));
    let level = 0.5 * log2(max(max(share, select(texel_wide * texel_wide, 1.0, is_rough)), 1.0));
    // Rays of rough surfaces are averaged: each has the light of the surface that it hits. A smooth one's image is blurred by the lobe.
    let light = mirrored_light(hit.place, hit_position, level, !is_rough, to_mirror, metres);
    // Lobes leave out scattered rays whose light the last frame did not show: others of the lobe stand for it better than the sky.
    let known = select(1.0, light.w, is_scattered);
    let rim = rim_fade(hit.place.xy, vec2<f32>(vec2<i32>(view.viewport_size)), view.edge_fade);
    let confidence = select(light.w, 1.0, is_scattered) * hit.certainty * rim;
    if !is_finite(light.r + light.g + light.b + confidence + metres) {
        return nothing;
    }
#ifdef PROJECTION_ORTHOGRAPHIC
    let image = metres;
#else
    let image = to_mirror + metres;
#endif
    let moves = select(0u, MOVES, moves_itself(hit.place, hit_position));
    return HitLight(vec4(light.rgb, confidence), max(image, 1e-6), known, moves);
}

@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let texel = pixel_in_view(workgroup.xy, invocation);
    if !all(texel < view.texture_size) {
        return;
    }
    let begin = begin_at(vec2<i32>(texel));
    textureStore(surfaces_output, texel, vec4(begin.surface, 0u, 0u));
    var result: TraceResult;
    if begin.start.z > 0.0 {
        result = trace(begin.start, begin.mirror, texel);
    } else if view.shows_hits == 0u {
        // Other textures are not read here.
        return;
    }
    textureStore(rays_output, texel, result.light);
    textureStore(hits_output, texel, vec4(result.hit));
}
