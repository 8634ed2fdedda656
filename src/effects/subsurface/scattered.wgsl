// Scattered light: part of a texel's light stays in it, the rest is the scattered light of coarser levels around it. Each level
// thus spreads part of the light by its own kernel, and all levels together form the profile.
#define_import_path bevy_lean_deferred::effects::subsurface::scattered

#import bevy_lean_deferred::gbuffer::layout::unpack_normal
#import bevy_lean_deferred::lighting::subsurface_light::{
    Entry, pack_entry, unpack_entry, unpack_material, unpack_metres,
}
#import bevy_lean_deferred::effects::subsurface::{
    bindings::view,
    entries::{Square, distance_in, kept_at},
    profile::{REACH, share_beyond},
    texel::{pixels_per_metre_at, to_viewer},
}
#ifndef PICTURE
#import bevy_lean_deferred::effects::subsurface::bindings::{entering_texture, normal_texture}
#import bevy_lean_deferred::effects::subsurface::texel::is_written
#endif

/// Offset of the two taps for a kernel of twice the squared width, in texels of the coarser level. By variances it would be 0.5;
/// this fits the light that leaves beside edges better.
const DRAWN: f32 = 0.6;
/// Largest aspect ratio to which kernels are stretched.
const WIDEST: f32 = 2.0;
/// Cosine of the largest angle by which surfaces are turned away.
const LEAST_FACING: f32 = 0.1;
/// Distance that separates surfaces, in texels of the coarser level.
const STEP: f32 = 0.25;
/// Largest slope of a surface, in metres of distance per metre across.
const STEEPEST: f32 = 3.0;

/// Surface at a texel.
struct Surface {
    level: u32,
    entry: Entry,
    /// In view space, facing the viewer.
    normal: vec3<f32>,
    /// Cosine of the angle by which it is turned away.
    facing: f32,
    /// Mean free path per channel, in pixels.
    paths: vec3<f32>,
    /// Width of a pixel at the surface, in metres.
    metres_per_pixel: f32,
    /// Increase in distance per pixel to the right and down.
    slope: vec2<f32>,
}

/// View-space normal of this word, turned to face the viewer, who is in the direction `toward`.
fn normal_of(word: u32, toward: vec3<f32>) -> vec3<f32> {
    let normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
    // Shading normals may lean away from the viewer.
    return normalize(normal + toward * max(LEAST_FACING - dot(normal, toward), 0.0));
}

/// Surface with this normal, which faces the viewer. `toward` is the direction to the viewer.
fn surface_with(normal: vec3<f32>, toward: vec3<f32>, entry: Entry, level: u32) -> Surface {
    var surface: Surface;
    surface.level = level;
    surface.entry = entry;
    surface.normal = normal;
    surface.facing = max(dot(normal, toward), LEAST_FACING);
    let pixels_per_metre = pixels_per_metre_at(entry.metres);
    surface.metres_per_pixel = 1.0 / pixels_per_metre;
    let slope = normal.xy * sign(view.pixels_per_metre) / max(normal.z, 1e-3);
    surface.slope = clamp(slope, vec2(-STEEPEST), vec2(STEEPEST)) * surface.metres_per_pixel;
    let paths = distance_in(entry.material) * pixels_per_metre;
    let longest = max(paths.r, max(paths.g, paths.b));
    surface.paths = paths * min(1.0, view.largest_radius / max(REACH * longest, 1e-6));
    return surface;
}

/// Interpolates the difference between the scattered light of the coarser level and the texel's own light, `along` of the way
/// between the four texels of that level from `first` on. w is the share of these that belongs to the surface. The point is `offset`
/// from the texel's centre, in texels of that level.
fn mean_between(surface: Surface, coarser: Square, first: vec2<i32>, along: vec2<f32>, offset: vec2<f32>) -> vec4<f32> {
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
        let kept = kept_at(coarser, first + corner);
        let way = select(vec2(0.0), slope, is_second);
        let expected = expected_at_first + way.x + way.y;
        let is_beside = saturate(2.0 - abs(unpack_metres(kept.word) - expected) * inverse_step);
        let is_alike = unpack_material(kept.word) == surface.entry.material;
        let weight = near.x * near.y * select(0.0, is_beside, is_alike);
        // Of the difference, so that uniform light is unchanged.
        sum += weight * vec4(kept.light - surface.entry.light, 1.0);
    }
    return sum;
}

/// `mean_between` at `offset` from the centre of the texel at `place`, in texels of the coarser level.
fn mean_beside(surface: Surface, coarser: Square, place: vec2<i32>, offset: vec2<f32>) -> vec4<f32> {
    let at = (vec2<f32>(place) + 0.5) * 0.5 + offset - 0.5;
    let first = floor(at);
    // Entries reach two texels around those beneath the workgroup's: as far as kernels are stretched.
    let known = clamp(vec2<i32>(first), coarser.corner, coarser.corner + coarser.side - 2);
    return mean_between(surface, coarser, known, at - first, offset);
}

/// Offset of the two taps on either side of the centre. A circle on a surface that is turned away looks narrow along one axis. The
/// kernel is as narrow, and the taps stretch it along the other axis; their squared offsets add up over all levels. The picture's
/// own offset is too small to matter.
fn offset_of(surface: Surface, middle: vec2<f32>) -> vec2<f32> {
#ifndef PICTURE
#ifdef DRAWN_OUT
    let width = min(1.0 / surface.facing, WIDEST);
    if width > 1.1 {
        let lean = surface.normal.xy - to_viewer(middle * f32(2u << surface.level)).xy * surface.facing;
        let along = normalize(vec2(-lean.y, lean.x) * sign(view.pixels_per_metre));
        return along * (DRAWN * sqrt(width * width - 1.0));
    }
#endif
#endif
    return vec2(0.0);
}

/// Change of a texel's light by scattering, from entries of the next coarser level.
fn added_at(place: vec2<i32>, surface: Surface, coarser: Square) -> vec3<f32> {
    let offset = offset_of(surface, (vec2<f32>(place) + 0.5) * 0.5);
    var sum: vec4<f32>;
    if all(offset == vec2(0.0)) {
        // The centre is a quarter of a texel from that of the coarser texel beneath it.
        let along = select(vec2(0.25), vec2(0.75), (place & vec2(1)) == vec2(0));
        sum = mean_between(surface, coarser, (place - 1) >> vec2(1u), along, vec2(0.0));
    } else {
        sum = mean_beside(surface, coarser, place, offset) + mean_beside(surface, coarser, place, -offset);
    }
    return share_beyond(f32(surface.level), surface.paths * surface.facing) * sum.rgb / max(sum.a, 1e-4);
}

#ifndef PICTURE
/// Content of the picture at a texel's centre.
struct Shown {
    middle: vec2<f32>,
    /// Number of the material; 0 if no light scatters there.
    material: u32,
    normal_word: u32,
}

fn shown_at(place: vec2<i32>, level: u32) -> Shown {
    let middle = (vec2<f32>(place) + 0.5) * f32(1u << level);
    let pixel = min(vec2<u32>(max(middle, vec2(0.0))), view.viewport_size - 1u);
    let entering = textureLoad(entering_texture, pixel, 0).r;
    let normal_word = textureLoad(normal_texture, view.viewport_origin + pixel, 0).r;
    let material = select(0u, unpack_material(entering), is_written(vec2<i32>(pixel)));
    return Shown(middle, material, normal_word);
}

/// Words of a texel with scattered light in place of the light that enters.
fn scattered(place: vec2<i32>, words: vec2<u32>, shown: Shown, level: u32, coarser: Square) -> vec2<u32> {
    var entry = unpack_entry(words);
    if entry.material == 0u {
        return vec2(0u);
    }
    let toward = to_viewer(shown.middle);
    var normal = toward;
    // The normal of another material may be that of another surface.
    if shown.material == entry.material {
        normal = normal_of(shown.normal_word, toward);
    }
    entry.light += added_at(place, surface_with(normal, toward, entry, level), coarser);
    return pack_entry(entry);
}
#endif
