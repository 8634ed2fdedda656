// Light that has scattered: some of a texel's light stays with it, the rest is what has scattered in coarser levels around it.
// So each level spreads some of the light by its own kernel, and all of them together are the profile. Either of the picture, in
// the listed tiles, or of a whole level and the next coarser one, which is only made here.
#import bevy_lean_deferred::gbuffer::layout::{light::unpack_light, unpack_normal}
#import bevy_lean_deferred::lighting::subsurface_light::{
    Entry, MATERIALS, pack_entry, scattering_distance, unpack_entry, unpack_material, unpack_metres,
}
#import bevy_lean_deferred::screen_space::subsurface::{
    bindings::{light_texture, normal_texture, scattered_texture, tiles, view},
    profile::{REACH, share_beyond},
    texel::{pixels_per_metre_at, to_viewer},
}
#ifdef PICTURE
#import bevy_lean_deferred::gbuffer::layout::light::within_halfs
#import bevy_lean_deferred::lighting::subsurface_light::unpack_receiver
#import bevy_lean_deferred::screen_space::subsurface::bindings::{output_texture, picture_texture}
#import bevy_lean_deferred::screen_space::subsurface::texel::{count_of_groups, listed_texel}
#else
#import bevy_lean_deferred::screen_space::subsurface::bindings::{coarser_texture, entering_texture, level_output}
#import bevy_lean_deferred::screen_space::subsurface::texel::is_any
#endif

/// How far the two places are away where a kernel is twice as wide in the square, in texels of the coarser level. By variances
/// it would be 0.5; this fits better what leaves beside edges.
const DRAWN: f32 = 0.6;
/// By how much wider than high a part of the surface may look for its kernel to be as wide.
const WIDEST: f32 = 2.0;
/// The cosine of how much surfaces are turned away at most.
const LEAST_FACING: f32 = 0.1;
/// The step between surfaces, in texels of the coarser level.
const STEP: f32 = 0.25;
/// How steep a surface may be, in metres of distance for each metre across.
const STEEPEST: f32 = 3.0;

/// The surface at a texel.
struct Surface {
    level: u32,
    entry: Entry,
    /// In view space, facing the viewer.
    normal: vec3<f32>,
    /// The cosine of how much it is turned away.
    facing: f32,
    /// Mean free paths of the channels, in pixels.
    paths: vec3<f32>,
    /// Metres that a pixel is wide there.
    metres_per_pixel: f32,
    /// How much further away the surface is with each pixel to the right and down.
    slope: vec2<f32>,
}

fn surface_at(place: vec2<i32>, entry: Entry, level: u32) -> Surface {
    var surface: Surface;
    surface.level = level;
    surface.entry = entry;
    let texel = f32(1u << level);
    let pixel = (vec2<f32>(place) + 0.5) * texel;
    let toward = to_viewer(pixel);
    let inside = min(vec2<u32>(pixel), view.viewport_size - 1u);
#ifdef PICTURE
    let is_known = true;
#else
    // The middle of a texel may show something else.
    let is_known = unpack_material(textureLoad(entering_texture, inside, 0).r) == entry.material;
#endif
    let word = textureLoad(normal_texture, view.viewport_origin + inside, 0).r;
    surface.normal = toward;
    if is_known {
        let normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
        // Shading normals may lean away from the viewer.
        surface.normal = normalize(normal + toward * max(LEAST_FACING - dot(normal, toward), 0.0));
    }
    surface.facing = max(dot(surface.normal, toward), LEAST_FACING);
    let pixels_per_metre = pixels_per_metre_at(entry.metres);
    surface.metres_per_pixel = 1.0 / pixels_per_metre;
    let slope = surface.normal.xy * sign(view.pixels_per_metre) / max(surface.normal.z, 1e-3);
    surface.slope = clamp(slope, vec2(-STEEPEST), vec2(STEEPEST)) * surface.metres_per_pixel;
    let paths = scattering_distance(tiles[MATERIALS + entry.material]) * pixels_per_metre;
    let longest = max(paths.r, max(paths.g, paths.b));
    surface.paths = paths * min(1.0, view.largest_radius / max(REACH * longest, 1e-6));
    return surface;
}

#ifndef PICTURE
/// Texels a side that a workgroup makes, each by one invocation, and of the coarser level beneath and two around them.
const MADE: u32 = 16u;
const SIDE: u32 = 12u;

var<workgroup> region: array<vec2<u32>, 144>;
var<private> region_corner: vec2<i32>;
/// Whether the coarser level is the one that is made here.
var<private> is_in_region: bool;
#endif

/// The words of an entry of the next coarser level.
fn coarser(place: vec2<i32>) -> vec2<u32> {
#ifndef PICTURE
    if is_in_region {
        let inside = clamp(place - region_corner, vec2(0), vec2(i32(SIDE) - 1));
        return region[inside.y * i32(SIDE) + inside.x];
    }
#endif
    let inside = clamp(place, vec2(0), vec2<i32>(textureDimensions(scattered_texture)) - 1);
    return select(vec2(0u), textureLoad(scattered_texture, inside, 0).rg, all(inside == place));
}

/// The mean of what light that has scattered in the coarser level has more than the texel's own, between the four texels of that
/// level from `first` on, `along` of the way; in w how much of what is there belongs to the surface. That is `offset` beside the
/// texel's middle.
fn mean_between(surface: Surface, first: vec2<i32>, along: vec2<f32>, offset: vec2<f32>) -> vec4<f32> {
    let texel = f32(2u << surface.level);
    let longest = max(surface.paths.r, max(surface.paths.g, surface.paths.b));
    let inverse_step = 1.0 / ((STEP * texel + longest) * surface.metres_per_pixel);
    let slope = surface.slope * texel;
    let expected_at_first = surface.entry.metres + dot(slope, offset - along);
    var sum = vec4(0.0);
    for (var i = 0; i < 4; i++) {
        let corner = vec2(i & 1, i >> 1u);
        let is_second = corner == vec2(1);
        let near = select(1.0 - along, along, is_second);
        let words = coarser(first + corner);
        let way = select(vec2(0.0), slope, is_second);
        let expected = expected_at_first + way.x + way.y;
        let is_beside = saturate(2.0 - abs(unpack_metres(words.x) - expected) * inverse_step);
        let is_alike = unpack_material(words.x) == surface.entry.material;
        let weight = near.x * near.y * select(0.0, is_beside, is_alike);
        // Of the difference: where there is none, nothing changes.
        sum += weight * vec4(unpack_light(words.y) - surface.entry.light, 1.0);
    }
    return sum;
}

/// The same, so many texels of the coarser level beside the middle of the texel at `place`.
fn mean_beside(surface: Surface, place: vec2<i32>, offset: vec2<f32>) -> vec4<f32> {
    let at = (vec2<f32>(place) + 0.5) * 0.5 + offset - 0.5;
    let first = floor(at);
    return mean_between(surface, vec2<i32>(first), at - first, offset);
}

/// A circle on a surface that is turned away looks narrow one way. The kernel is as narrow, and drawn out the other way: by two
/// places on either side of the middle, whose squared offsets add up over all levels. The picture's own is too small to matter.
fn offset_of(surface: Surface, middle: vec2<f32>) -> vec2<f32> {
#ifdef DRAWN_OUT
    let width = min(1.0 / surface.facing, WIDEST);
    if width > 1.1 {
        let lean = surface.normal.xy - to_viewer(middle * f32(2u << surface.level)).xy * surface.facing;
        let along = normalize(vec2(-lean.y, lean.x) * sign(view.pixels_per_metre));
        return along * (DRAWN * sqrt(width * width - 1.0));
    }
#endif
    return vec2(0.0);
}

/// What scattering adds to the light of a texel.
fn added_at(place: vec2<i32>, surface: Surface) -> vec3<f32> {
    let offset = offset_of(surface, (vec2<f32>(place) + 0.5) * 0.5);
    var sum: vec4<f32>;
    if all(offset == vec2(0.0)) {
        // The middle is a quarter of a texel from that of the one beneath it.
        let along = select(vec2(0.25), vec2(0.75), (place & vec2(1)) == vec2(0));
        sum = mean_between(surface, (place - 1) >> vec2(1u), along, vec2(0.0));
    } else {
        sum = mean_beside(surface, place, offset) + mean_beside(surface, place, -offset);
    }
    return share_beyond(f32(surface.level), surface.paths * surface.facing) * sum.rgb / max(sum.a, 1e-4);
}

#ifdef PICTURE
fn show(pixel: vec2<i32>) {
    let entry = unpack_entry(textureLoad(light_texture, pixel, 0).rg);
    if entry.material == 0u {
        return;
    }
    let added = added_at(pixel, surface_at(pixel, entry, 0u));
    // Where that is nothing, or not a number, the picture stays as it is.
    if any(added != vec3(0.0)) && all(abs(added) < vec3(1e30)) {
        let receiver = unpack_receiver(textureLoad(picture_texture, pixel, 0));
        let color = within_halfs(receiver.color.rgb + receiver.leaving * added);
        textureStore(output_texture, vec2<i32>(view.viewport_origin) + pixel, vec4(color, receiver.color.a));
    }
}

@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let count = count_of_groups();
    for (var group = workgroup.x; group < count; group += workgroups.x) {
        show(listed_texel(group, invocation).place);
    }
}
#else
/// The words of a texel with what has scattered in place of what enters.
fn scattered(place: vec2<i32>, words: vec2<u32>, level: u32) -> vec2<u32> {
    var entry = unpack_entry(words);
    if entry.material == 0u {
        return vec2(0u);
    }
    entry.light += added_at(place, surface_at(place, entry, level));
    return pack_entry(entry);
}

/// Levels may be smaller than what a workgroup makes.
fn store(place: vec2<i32>, words: vec2<u32>) {
    if all(place < vec2<i32>(textureDimensions(level_output))) {
        textureStore(level_output, place, vec4(words, 0u, 0u));
    }
}

/// Of the texels from `corner` on.
fn make(corner: vec2<i32>, invocation: u32) {
    let place = corner + vec2<i32>(vec2(invocation % MADE, invocation / MADE));
    let inside = min(place, vec2<i32>(textureDimensions(light_texture)) - 1);
    let words = select(vec2(0u), textureLoad(light_texture, inside, 0).rg, all(inside == place));
    if !is_any(words.x != 0u, invocation) {
        store(place, vec2(0u));
        return;
    }
    region_corner = corner / 2 - 2;
    is_in_region = false;
    if invocation < SIDE * SIDE {
        let beneath = region_corner + vec2<i32>(vec2(invocation % SIDE, invocation / SIDE));
        let known = clamp(beneath, vec2(0), vec2<i32>(textureDimensions(coarser_texture)) - 1);
        let coarser_words = textureLoad(coarser_texture, known, 0).rg;
        region[invocation] = scattered(beneath, select(vec2(0u), coarser_words, all(known == beneath)), view.level + 1u);
    }
    workgroupBarrier();
    is_in_region = true;
    store(place, scattered(place, words, view.level));
}

@compute @workgroup_size(256, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let size = (textureDimensions(light_texture) + MADE - 1u) / MADE;
    for (var group = workgroup.x; group < size.x * size.y; group += workgroups.x) {
        make(vec2<i32>(MADE * vec2(group % size.x, group / size.x)), invocation);
    }
}
#endif
