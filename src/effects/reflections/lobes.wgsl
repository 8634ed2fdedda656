// Lobes in the last frames. The scattered rays of each of four frames take another quarter of the directions, so the mean of
// four lobes has all of them, and is the same in each frame at rest.
#define_import_path bevy_lean_deferred::effects::reflections::lobes

#import bevy_lean_deferred::gbuffer::layout::light::{pack_light, unpack_light}
#import bevy_lean_deferred::effects::reflections::bindings::{history_texture, lobes_texture, view, view_position}
#import bevy_lean_deferred::effects::reflections::surface::{SAME_SURFACE, LastPlace, last_place, step_at}
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

/// The lobes of the last frame at a place in it; 0 if it showed another surface there. `offset` is that from a texel's coordinates to
/// its ray's begin, in pixels.
fn lobes_at(place: LastPlace, offset: vec2<f32>) -> vec4<u32> {
    let is_inside = all(place.at >= vec2(0.0)) && all(place.at < view.last_viewport_size);
    let kept = textureLoad(history_texture, vec2<i32>(place.at), 0).a * view.metres_per_unit;
    let weight = weight_of_match(kept, place.expected.x, place.expected.y, place.tolerance);
    if !is_inside || weight < 0.5 {
        return vec4(0u);
    }
    // The nearest: each texel keeps its own directions.
    let side = f32(view.divisor);
    let last = ceil(view.last_viewport_size / side) - 1.0;
    let texel = clamp(floor((place.at - offset) / side + 0.5), vec2(0.0), last);
    return textureLoad(lobes_texture, vec2<i32>(texel), 0);
}

/// The lobes of the last frames of the surface of a texel, whose ray begins at a pixel.
fn last_lobes(texel: vec2<i32>, pixel: vec2<i32>, depth: f32) -> vec4<u32> {
    if view.has_lobes == 0u || view.exposure_ratio == 0.0 {
        return vec4(0u);
    }
    let seen = vec3(vec2<f32>(pixel) + 0.5, depth);
    let position = view_position(seen.xy, depth);
    let offset = vec2<f32>(pixel - texel * view.divisor) + 0.5;
    var lobes = lobes_at(last_place(seen, position), offset);
    if lobes.w == 0u && view.has_motion == 0u && view.carries_surfaces != 0u {
        let at = seen.xy / vec2<f32>(view.viewport_size) * view.last_viewport_size;
        lobes = lobes_at(LastPlace(at, vec2(-position.z), step_at(-position.z, SAME_SURFACE)), offset);
    }
    if view.exposure_ratio != 1.0 {
        for (var i = 0; i < 3; i++) {
            lobes[i] = pack_light(unpack_light(lobes[i]) * view.exposure_ratio);
        }
    }
    return lobes;
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
