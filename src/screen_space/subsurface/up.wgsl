// Light that has scattered: some of a texel's light stays with it, the rest is what has scattered in coarser levels around it.
// So each level spreads some of the light by its own kernel, and all of them together are the profile. Either of the picture, in
// the listed tiles, or of a whole level and the next coarser one, which is only made here.
#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, unpack_normal}
#import bevy_lean_deferred::lighting::subsurface_light::{
    Entry, MATERIALS, pack_entry, scattering_distance, unpack_entry,
}
#import bevy_lean_deferred::screen_space::subsurface::{
    bindings::{light_texture, normal_texture, scattered_texture, tiles, view},
    profile::{REACH, share_beyond},
    texel::{pixels_per_metre_at, to_viewer},
}
#ifdef PICTURE
#import bevy_lean_deferred::lighting::subsurface_light::unpack_receiver
#import bevy_lean_deferred::screen_space::subsurface::bindings::{output_texture, picture_texture}
#import bevy_lean_deferred::screen_space::subsurface::texel::{count_of_groups, listed_texel}
#else
#import bevy_lean_deferred::screen_space::subsurface::bindings::{coarser_texture, level_output}
#endif

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
}

fn surface_at(place: vec2<i32>, entry: Entry, level: u32) -> Surface {
    var surface: Surface;
    surface.level = level;
    surface.entry = entry;
    let texel = f32(1u << level);
    let pixel = (vec2<f32>(place) + 0.5) * texel;
    let toward = to_viewer(pixel);
    let inside = min(vec2<u32>(pixel), view.viewport_size - 1u);
    let word = textureLoad(normal_texture, view.viewport_origin + inside, 0).r;
    surface.normal = toward;
    if word != NO_GEOMETRY {
        let normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
        // Shading normals may lean away from the viewer.
        surface.normal = normalize(normal + toward * max(LEAST_FACING - dot(normal, toward), 0.0));
    }
    surface.facing = max(dot(surface.normal, toward), LEAST_FACING);
    let pixels_per_metre = pixels_per_metre_at(entry.metres);
    surface.metres_per_pixel = 1.0 / pixels_per_metre;
    let paths = scattering_distance(tiles[MATERIALS + entry.material]) * pixels_per_metre;
    let longest = max(paths.r, max(paths.g, paths.b));
    surface.paths = paths * min(1.0, view.largest_radius / max(REACH * longest, 1e-6));
    return surface;
}

/// How much further away the surface is so many pixels from the middle of the texel.
fn further(surface: Surface, pixels: vec2<f32>) -> f32 {
    let across = pixels * sign(view.pixels_per_metre) * surface.metres_per_pixel;
    let most = STEEPEST * (abs(across.x) + abs(across.y));
    return clamp(dot(surface.normal.xy, across) / max(surface.normal.z, 1e-3), -most, most);
}

#ifndef PICTURE
/// Texels a side of the region of the coarser level that a workgroup makes, and its first one.
const SIDE: i32 = 8;

var<workgroup> region: array<vec2<u32>, 64>;
var<private> region_corner: vec2<i32>;
/// Whether the coarser level is the one that is made here.
var<private> is_in_region: bool;
#endif

/// The entry of the next coarser level.
fn coarser(place: vec2<i32>) -> vec2<u32> {
#ifndef PICTURE
    if is_in_region {
        let inside = clamp(place - region_corner, vec2(0), vec2(SIDE - 1));
        return region[inside.y * SIDE + inside.x];
    }
#endif
    return textureLoad(scattered_texture, place, 0).rg;
}

/// The mean of what light that has scattered in the coarser level has more than the texel's own, around a place of that level;
/// in w how much of what is there belongs to the surface.
fn mean_around(surface: Surface, place: vec2<i32>, at: vec2<f32>) -> vec4<f32> {
    let texel = f32(2u << surface.level);
    let first = floor(at - 0.5);
    let along = at - 0.5 - first;
    let longest = max(surface.paths.r, max(surface.paths.g, surface.paths.b));
    let step = (STEP * texel + longest) * surface.metres_per_pixel;
    // The middle of this texel, in those of the coarser level.
    let middle = (vec2<f32>(place) + 0.5) * 0.5;
    var sum = vec4(0.0);
    for (var i = 0; i < 4; i++) {
        let corner = vec2<f32>(vec2(i & 1, i >> 1u));
        let near = mix(1.0 - along, along, corner);
        let other = unpack_entry(coarser(vec2<i32>(first + corner)));
        let expected = surface.entry.metres + further(surface, (first + corner + 0.5 - middle) * texel);
        let is_beside = saturate(2.0 - abs(other.metres - expected) / step);
        let weight = near.x * near.y * select(0.0, is_beside, other.material == surface.entry.material);
        // Of the difference: where there is none, nothing changes.
        sum += weight * vec4(other.light - surface.entry.light, 1.0);
    }
    return sum;
}

/// What scattering adds to the light of a texel.
fn added_at(place: vec2<i32>, surface: Surface) -> vec3<f32> {
    // A circle on a surface that is turned away looks narrow one way. The kernel is as narrow, and drawn out the other way: by
    // two places, of which the sum of the squared offsets over all levels is what it lacks.
    let paths = surface.paths * surface.facing;
    let width = min(1.0 / surface.facing, WIDEST);
    let level = f32(surface.level);
    let middle = (vec2<f32>(place) + 0.5) * 0.5;
    var sum: vec4<f32>;
#ifdef DRAWN_OUT
    let is_wide = width > 1.1;
#else
    let is_wide = false;
#endif
    if !is_wide {
        sum = mean_around(surface, place, middle);
    } else {
        let lean = surface.normal.xy - to_viewer(middle * f32(2u << surface.level)).xy * surface.facing;
        let along = normalize(vec2(-lean.y, lean.x) * sign(view.pixels_per_metre));
        let offset = along * (0.5 * sqrt(width * width - 1.0));
        sum = mean_around(surface, place, middle + offset) + mean_around(surface, place, middle - offset);
    }
    return share_beyond(level, paths) * sum.rgb / max(sum.a, 1e-4);
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
        let color = receiver.color.rgb + receiver.leaving * added;
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
var<workgroup> has_light: atomic<u32>;
var<workgroup> is_needed: u32;

/// The words of a texel with what has scattered in place of what enters.
fn scattered(place: vec2<i32>, words: vec2<u32>, level: u32) -> vec2<u32> {
    var entry = unpack_entry(words);
    if entry.material == 0u {
        return vec2(0u);
    }
    entry.light += added_at(place, surface_at(place, entry, level));
    return pack_entry(entry);
}

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let index = vec2<i32>(vec2(invocation & 7u, invocation >> 3u));
    let place = vec2<i32>(workgroup.xy) * SIDE + index;
    let words = textureLoad(light_texture, place, 0).rg;
    if invocation == 0u {
        atomicStore(&has_light, 0u);
    }
    workgroupBarrier();
    if words.x != 0u {
        atomicStore(&has_light, 1u);
    }
    workgroupBarrier();
    if invocation == 0u {
        is_needed = atomicLoad(&has_light);
    }
    if workgroupUniformLoad(&is_needed) == 0u {
        textureStore(level_output, place, vec4(0u));
        return;
    }
    // Four of its texels a side are beneath those of this level; two more on each side are around them.
    region_corner = vec2<i32>(workgroup.xy) * (SIDE / 2) - 2;
    let beneath = region_corner + index;
    is_in_region = false;
    region[invocation] = scattered(beneath, textureLoad(coarser_texture, beneath, 0).rg, view.level + 1u);
    workgroupBarrier();
    is_in_region = true;
    textureStore(level_output, place, vec4(scattered(place, words, view.level), 0u, 0u));
}
#endif
