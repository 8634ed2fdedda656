// Lobes in the last frames. The scattered rays of each of four frames take another quarter of the directions, so the mean of
// four lobes has all of them, and is the same in each frame at rest.
#define_import_path bevy_lean_deferred::effects::reflections::lobes

#import bevy_lean_deferred::gbuffer::layout::light::{pack_light, unpack_light}
#import bevy_lean_deferred::effects::reflections::bindings::{history_texture, lobes_texture, view, view_position}
#import bevy_lean_deferred::effects::reflections::surface::{LastPlace, carried_place, last_place}
#import bevy_lean_deferred::effects::reprojection::weight_of_match

/// Frames in which the rays of rough surfaces take all of their directions.
const PHASES: u32 = 4u;

/// Bit of the newest lobe in the last of a texel's words, if it is known. Below it, that word has the confidences, eight bits each,
/// the newest one lowest. The other words have light times confidence.
const KNOWN: u32 = 1u << 24u;

/// Shift in a frame of this phase of the two numbers that choose a ray's direction. The sixteen rays stay evenly spread, and those of
/// all phases are, too: each has a quarter of the first number's sixteenth, and another quarter of the second number.
fn shift_of(phase: u32) -> vec2<f32> {
    let parts = vec2(f32(phase), f32(reverseBits(phase) >> 30u)) / f32(PHASES);
    return vec2((parts.x - 0.375) / 16.0, parts.y);
}

/// Pixels by which a mirror image is followed at most in a frame.
const MOST_MOVED: f32 = 64.0;

/// Texels within which a place is that of a single texel. At rest all are, and each texel keeps its own directions.
const EXACT: f32 = 1.0 / 32.0;

/// Place of a texel's lobe among those of the last frame.
struct LobePlace {
    /// In texels: 0 is the first texel, not its corner.
    at: vec2<f32>,
    /// False if the last frame showed another surface there.
    is_known: bool,
}

/// Place of the lobe whose ray begins at a place of the last frame. `offset`: from a texel's coordinates to its ray's begin, in pixels.
fn lobe_place(place: LastPlace, offset: vec2<f32>) -> LobePlace {
    let is_inside = all(place.at >= vec2(0.0)) && all(place.at < view.last_viewport_size);
    let kept = textureLoad(history_texture, vec2<i32>(place.at), 0).a * view.metres_per_unit;
    let weight = weight_of_match(kept, place.expected.x, place.expected.y, place.tolerance);
    return LobePlace((place.at - offset) / f32(view.divisor), is_inside && weight >= 0.5);
}

/// Pixels by which a mirror image moved against its mirror since the last frame, both at rest in the world. The lobe moves with it.
fn moved_image(position: vec3<f32>, roughness: f32, image: f32) -> vec2<f32> {
    // Rough lobes lean towards the normal, and follow less (Lagarde and de Rousiers 2014, "Moving Frostbite to PBR").
    let share = (1.0 - roughness) * (sqrt(1.0 - roughness) + roughness);
#ifdef PROJECTION_ORTHOGRAPHIC
    let behind = position - vec3(0.0, 0.0, share * image);
#else
    let behind = position * mix(1.0, image / max(length(position), 1e-6), share);
#endif
    let of_image = view.last_pixel_from_view * vec4(behind, 1.0);
    let of_mirror = view.last_pixel_from_view * vec4(position, 1.0);
    let moved = of_image.xy / of_image.w - of_mirror.xy / of_mirror.w;
    let is_small = min(of_image.w, of_mirror.w) > 0.0 && dot(moved, moved) < MOST_MOVED * MOST_MOVED;
    return select(vec2(0.0), moved, image > 0.0 && is_small);
}

/// Place in the last frame of the lobe of a texel, whose ray begins at a pixel. `slope` is that of depth per pixel, and `image` the
/// distance to the mirror image, seen straight through the mirror.
fn last_lobe_place(
    texel: vec2<i32>,
    pixel: vec2<i32>,
    depth: f32,
    slope: vec2<f32>,
    roughness: f32,
    image: f32,
) -> LobePlace {
    let seen = vec3(vec2<f32>(pixel) + 0.5, depth);
    let position = view_position(seen.xy, depth);
    let offset = vec2<f32>(pixel - texel * view.divisor) + 0.5;
    let moved = moved_image(position, roughness, image);
    let shifted = seen + vec3(moved, dot(slope, moved));
    var lobe = lobe_place(last_place(shifted, view_position(shifted.xy, shifted.z)), offset);
    if !lobe.is_known && any(moved != vec2(0.0)) {
        lobe = lobe_place(last_place(seen, position), offset);
    }
    if !lobe.is_known && view.has_motion == 0u && view.carries_surfaces != 0u {
        lobe = lobe_place(carried_place(seen, position), offset);
    }
    return lobe;
}

/// Lobes that the last frames made at a texel.
fn lobes_at(texel: vec2<f32>) -> vec4<u32> {
    let last = ceil(view.last_viewport_size / f32(view.divisor)) - 1.0;
    return textureLoad(lobes_texture, vec2<i32>(clamp(texel, vec2(0.0), last)), 0);
}

/// Means of four texels' lobes, `kept`, with these weights.
fn mean_lobes(kept: array<vec4<u32>, 4>, weights: vec4<f32>) -> vec4<u32> {
    var texels = kept;
    var lobes = vec4(0u);
    for (var age = 0u; age < 3u; age++) {
        var sum = vec4(0.0);
        var known = 0.0;
        for (var i = 0u; i < 4u; i++) {
            let word = texels[i].w;
            sum += weights[i] * unpack_lobe(texels[i][age], word, age);
            known += select(0.0, weights[i], (word & (KNOWN << age)) != 0u);
        }
        if known > 0.0 {
            let lobe = sum / known;
            lobes[age] = pack_light(lobe.rgb);
            lobes.w |= (u32(saturate(lobe.a) * 255.0 + 0.5) << (8u * age)) | (KNOWN << age);
        }
    }
    return lobes;
}

/// `lobes` in the exposure of this frame.
fn exposed(lobes: vec4<u32>) -> vec4<u32> {
    var now = lobes;
    if view.exposure_ratio != 1.0 {
        for (var i = 0; i < 3; i++) {
            now[i] = pack_light(unpack_light(now[i]) * view.exposure_ratio);
        }
    }
    return now;
}

/// `last` with the `lobe` of this frame: light times confidence, and confidence. The oldest one is dropped.
fn with_lobe(last: vec4<u32>, lobe: vec4<f32>) -> vec4<u32> {
    let confidences = u32(saturate(lobe.a) * 255.0 + 0.5) | ((last.w & 0xffffu) << 8u);
    let known = KNOWN | ((last.w & (3u * KNOWN)) << 1u);
    return vec4(pack_light(lobe.rgb), last.xy, confidences | known);
}

/// Lobe of age `i` of a texel's; 0 if it is not known.
fn unpack_lobe(light: u32, word: u32, i: u32) -> vec4<f32> {
    let lobe = vec4(unpack_light(light), f32((word >> (8u * i)) & 0xffu) / 255.0);
    return select(vec4(0.0), lobe, (word & (KNOWN << i)) != 0u);
}

/// Mean of the lobes of the last frames and of this one, which `lobes` has already.
fn mean_lobe(last: vec4<u32>, lobes: vec4<u32>) -> vec4<f32> {
    // Phases of even and of odd frames: the sum does not depend on which of them is this frame's.
    let even = unpack_lobe(lobes.x, lobes.w, 0u) + unpack_lobe(lobes.z, lobes.w, 2u);
    let odd = unpack_lobe(lobes.y, lobes.w, 1u) + unpack_lobe(last.z, last.w, 2u);
    return (even + odd) / f32(countOneBits((lobes.w >> 24u) | ((last.w & (4u * KNOWN)) >> 23u)));
}
