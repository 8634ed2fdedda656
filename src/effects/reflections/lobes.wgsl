// Lobes in the last frames. The scattered rays of each of four frames take another quarter of the directions, so the mean of
// four lobes has all of them, and is the same in each frame at rest.
#define_import_path bevy_lean_deferred::effects::reflections::lobes

#import bevy_lean_deferred::gbuffer::layout::light::{pack_light, unpack_light}
#import bevy_lean_deferred::effects::reflections::bindings::{
    history_texture, homogeneous_pixel, lobes_texture, view, view_position,
}
#import bevy_lean_deferred::effects::reflections::surface::{
    LEAST_OWN, LastPlace, carried_place, last_place, lobe_width, motion_at, with_view,
}
#import bevy_lean_deferred::effects::reprojection::weight_of_match

/// Frames in which scattered rays take all of their directions.
const PHASES: u32 = 4u;

/// Bit of the newest lobe in the last of a texel's words, if it is known. Below it, that word has the confidences, eight bits each,
/// the newest one lowest. The other words have light times confidence.
const KNOWN: u32 = 1u << 24u;
/// Bit of the newest lobe in that word, if it shows something that moved on its own.
const MOVED: u32 = 1u << 27u;

/// Shift in a frame of this phase of the two numbers that choose a ray's direction. The sixteen rays stay evenly spread. Those of
/// all phases are, too, on rough surfaces: each has a quarter of the first number's sixteenth, and another quarter of the second number.
/// On smooth ones a texel has another ray in each phase, whose second number is another quarter already.
fn shift_of(phase: u32, is_rough: bool) -> vec2<f32> {
    let parts = vec2(f32(phase), f32(reverseBits(phase) >> 30u)) / f32(PHASES);
    return vec2((parts.x - 0.375) / 16.0, select(0.0, parts.y, is_rough));
}

/// Pixels by which a mirror image is followed at most in a frame.
const MOST_MOVED: f32 = 64.0;

/// Share of the path of a mirror image that lobes of any roughness follow, as found by the bench `motion`.
const OF_PATH: f32 = 0.8;

/// Pixels that the camera's motion moves a mirror at rest, from which on a mirror that moves with the camera is told apart, and its least
/// share of that motion. Below both, rounding of motion vectors would look like a share.
const CARRIED_FROM: f32 = 0.25;
const LEAST_CARRIED: f32 = 0.05;

/// Tolerances: differences of the last frames' lobes from this frame's lobe at which they weigh 1/2, relative to the mean difference of
/// this frame's rays from it. Lobes are means of sixteen rays and more, so they differ by less than rays do. This one is for lobes that
/// show something that moves on its own.
const OF_MOVERS: f32 = 0.4;
/// Least one of a mirror image that moves.
const OF_IMAGES: f32 = 0.6;
/// That of one that moves by the lobe's radius; inversely proportional to its motion.
const OF_SLOW: f32 = 0.06;
/// From here on all lobes weigh 1.
const ALL_ALIKE: f32 = 16.0;

/// Texels within which a place is that of a single texel. At rest all are, and each texel keeps its own lobes.
const EXACT: f32 = 1.0 / 32.0;

/// Place of a texel's lobe among those of the last frame.
struct LobePlace {
    /// In texels, relative to the texel.
    at: vec2<f32>,
    /// False if the last frame showed another surface there.
    is_known: bool,
    /// Difference from this frame's lobe at which it weighs 1/2: see `OF_IMAGES`.
    tolerance: f32,
}

/// Place of the lobe of a texel whose ray begins at `begin`, in pixels, and began at a place of the last frame.
fn lobe_place(place: LastPlace, begin: vec2<f32>) -> LobePlace {
    let is_inside = all(place.at >= vec2(0.0)) && all(place.at < view.last_viewport_size);
    let kept = textureLoad(history_texture, vec2<i32>(place.at), 0).a * view.metres_per_unit;
    let weight = weight_of_match(kept, place.expected.x, place.expected.y, place.tolerance);
    return LobePlace((place.at - begin) / f32(view.divisor), is_inside && weight >= 0.5, ALL_ALIKE);
}

/// Homogeneous pixel of the last frame.
fn last_pixel(position: vec3<f32>) -> vec4<f32> {
    return view.last_pixel_from_view * vec4(position, 1.0);
}

/// Transforms a position from this frame's view space to the last frame's. Assumes that the projection is the same.
fn last_view_position(position: vec3<f32>) -> vec3<f32> {
    let m = view.last_pixel_from_view;
    let ahead = view.last_distance.xyz;
    let centre = vec2(dot(vec3(m[0].x, m[1].x, m[2].x), ahead), dot(vec3(m[0].y, m[1].y, m[2].y), ahead));
    let at = last_pixel(position);
    return vec3((at.xy - centre * at.w) / view.pixels_per_metre, -at.w);
}

/// Mirrors an offset in the plane of a mirror.
fn mirrored(offset: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return offset - 2.0 * dot(offset, normal) * normal;
}

/// Metres across the view by which the surface at `position` moved on its own since the last frame; 0 if the last frame showed another
/// one there, by more than `tolerance` metres of distance.
fn own_displacement(position: vec3<f32>, tolerance: f32) -> vec3<f32> {
    let pixel = homogeneous_pixel(position, 1.0);
    let place = pixel.xy / pixel.w;
    let at_rest = last_pixel(position);
    let is_seen = min(pixel.w, at_rest.w) > 0.0 && all(place >= vec2(0.0)) && all(place < vec2<f32>(view.viewport_size));
    if !is_seen {
        return vec3(0.0);
    }
    let at = with_view(place) - motion_at(vec2<i32>(place)) * view.last_viewport_size;
    let kept = textureLoad(history_texture, vec2<i32>(at), 0).a * view.metres_per_unit;
    let deeper = kept - at_rest.w;
    let surface = last_pixel(position * (1.0 - deeper / position.z));
    let moved = at - surface.xy / surface.w;
    let is_same = all(at >= vec2(0.0)) && all(at < view.last_viewport_size) && abs(deeper) < tolerance;
    // The jitter of two frames differs by up to a pixel.
    return select(vec3(0.0), vec3(moved * kept / view.pixels_per_metre, 0.0), is_same && dot(moved, moved) > 1.0);
}

/// Tolerance of the distance of the surface that a lobe's rays hit, as a share of their length: the mean of their lengths is not that of
/// the ray in the mirror's direction.
const SAME_HIT: f32 = 0.3;

/// Pixels by which a mirror image moved against its mirror since the last frame. The lobe moves with it. The last frame showed the
/// mirror `at` a pixel, and this one at `seen`. `moves`: rays hit something that moves on its own.
fn moved_image(
    at: vec2<f32>,
    seen: vec2<f32>,
    position: vec3<f32>,
    normal: vec3<f32>,
    roughness: f32,
    image: f32,
    moves: bool,
) -> vec2<f32> {
    // Rough lobes lean towards the normal, and follow less (Lagarde and de Rousiers 2014, "Moving Frostbite to PBR").
    let share = OF_PATH * (1.0 - roughness) * (sqrt(1.0 - roughness) + roughness);
    let of_mirror = last_pixel(position);
    let mirror_at_rest = of_mirror.xy / of_mirror.w;
#ifdef PROJECTION_ORTHOGRAPHIC
    let of_image = last_pixel(position - vec3(0.0, 0.0, share * image));
#else
    // From the mirror to where its rays hit, and where that was.
    var to_hit = mirrored(position * (image / max(length(position), 1e-6) - 1.0), normal);
    if moves {
        to_hit += own_displacement(position + to_hit, SAME_HIT * length(to_hit));
    }
    let of_image = last_pixel(position + share * mirrored(to_hit, normal));
#endif
    var moved = of_image.xy / of_image.w - mirror_at_rest;
#ifdef PROJECTION_PERSPECTIVE
    // In the view space of a mirror that moves with the camera, the world moves instead.
    let path = with_view(seen) - mirror_at_rest;
    if view.has_motion != 0u && dot(path, path) > CARRIED_FROM * CARRIED_FROM {
        let carried = saturate(dot(at - mirror_at_rest, path) / dot(path, path));
        if carried > LEAST_CARRIED {
            let last = last_view_position(position + to_hit) - position;
            let pixel = homogeneous_pixel(position + share * mirrored(last, normal), 1.0);
            moved = mix(moved, pixel.xy / pixel.w - seen, carried);
        }
    }
#endif
    return select(vec2(0.0), moved, image > 0.0 && min(of_image.w, of_mirror.w) > 0.0);
}

/// Place in the last frame of the lobe of a texel, whose ray begins at a pixel. `slope` is that of depth per texel, and `image` the
/// distance to the mirror image, seen straight through the mirror. `moves`: rays hit something that moves on its own.
fn last_lobe_place(
    pixel: vec2<i32>,
    depth: f32,
    slope: vec2<f32>,
    normal: vec3<f32>,
    roughness: f32,
    image: f32,
    moves: bool,
) -> LobePlace {
    let seen = vec3(vec2<f32>(pixel) + 0.5, depth);
    let position = view_position(seen.xy, depth);
    var moved = vec2(0.0);
    let is_moving = view.carries_surfaces != 0u || moves;
    if is_moving {
        moved = moved_image(last_place(seen, position).at, seen.xy, position, normal, roughness, image, moves);
    }
    let pixels = length(moved);
    let texels_per_pixel = 1.0 / f32(view.divisor);
    // Radius of the lobe, in pixels. Computed here, where fewer registers are in use than above.
    let radius = roughness * roughness * lobe_width(max(image - length(position), 0.0), image);
    // If the image moved by less than the lobe's width, the lobe without that motion is close enough.
    let tries = select(1, 2, pixels > 0.0 && pixels < 0.5 * radius);
    var lobe: LobePlace;
    var own = 0.0;
    for (var i = 0; i < tries && !lobe.is_known && pixels < MOST_MOVED; i++) {
        let shifted = seen + vec3(moved, dot(slope, moved) * texels_per_pixel);
        let place = last_place(shifted, view_position(shifted.xy, shifted.z));
        lobe = lobe_place(place, seen.xy);
        own = place.own;
        moved = vec2(0.0);
    }
    if !lobe.is_known && view.has_motion == 0u && view.carries_surfaces != 0u {
        lobe = lobe_place(carried_place(seen, position), seen.xy);
    }
    // All rays miss: there is no image to follow, the radius is 0, and last lobes that have light weigh nothing.
    let slow = clamp(OF_SLOW * radius / max(pixels, 1e-6), OF_IMAGES, ALL_ALIKE);
    lobe.tolerance = select(ALL_ALIKE, slow, is_moving);
    lobe.tolerance = select(lobe.tolerance, OF_MOVERS, own > LEAST_OWN);
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
            lobes.w |= word & (MOVED << age);
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

/// `last` with the `lobe` of this frame: light times confidence, and confidence. `bits` are its `KNOWN` and `MOVED`. The oldest one is
/// dropped.
fn with_lobe(last: vec4<u32>, lobe: vec4<f32>, bits: u32) -> vec4<u32> {
    let confidences = u32(saturate(lobe.a) * 255.0 + 0.5) | ((last.w & 0xffffu) << 8u);
    let older = (last.w & (3u * (KNOWN | MOVED))) << 1u;
    return vec4(pack_light(lobe.rgb), last.xy, confidences | older | bits);
}

/// True if one of the lobes shows something that moved on its own. `lobes` has that of this frame.
fn has_moved(last: vec4<u32>, lobes: vec4<u32>) -> bool {
    return ((lobes.w & (7u * MOVED)) | (last.w & (4u * MOVED))) != 0u;
}

/// Lobe of age `i` of a texel's; 0 if it is not known.
fn unpack_lobe(light: u32, word: u32, i: u32) -> vec4<f32> {
    let lobe = vec4(unpack_light(light), f32((word >> (8u * i)) & 0xffu) / 255.0);
    return select(vec4(0.0), lobe, (word & (KNOWN << i)) != 0u);
}

/// A kept lobe and its weight.
struct KeptLobe {
    lobe: vec4<f32>,
    weight: f32,
}

/// Lobe of age `i`, times a weight of 1/2 if it differs from `now` by `most`, summed over its components. Lobes that are not known have
/// none.
fn kept_lobe(light: u32, word: u32, i: u32, now: vec4<f32>, most: f32) -> KeptLobe {
    let lobe = unpack_lobe(light, word, i);
    let off = abs(lobe - now);
    let relative = (off.r + off.g + off.b + off.a) / max(most, 1e-12);
    let weight = select(0.0, 1.0 / (1.0 + relative * relative), (word & (KNOWN << i)) != 0u);
    return KeptLobe(lobe * weight, weight);
}

/// Mean of the lobes of the last frames and of this one, which `lobes` has already. Those of the last frames weigh less the more they
/// differ from it: see `kept_lobe`.
fn mean_lobe(last: vec4<u32>, lobes: vec4<u32>, most: f32) -> vec4<f32> {
    let now = unpack_lobe(lobes.x, lobes.w, 0u);
    let of_now = select(0.0, 1.0, (lobes.w & KNOWN) != 0u);
    let second = kept_lobe(lobes.y, lobes.w, 1u, now, most);
    let third = kept_lobe(lobes.z, lobes.w, 2u, now, most);
    let fourth = kept_lobe(last.z, last.w, 2u, now, most);
    // Phases of even and of odd frames: the sum does not depend on which of them is this frame's.
    let sum = (now + third.lobe) + (second.lobe + fourth.lobe);
    let weights = (of_now + third.weight) + (second.weight + fourth.weight);
    return sum / max(weights, 1e-6);
}
