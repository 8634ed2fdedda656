// Light that has scattered: some of a texel's light stays with it, the rest is what has scattered in coarser levels around it.
// So each level spreads some of the light by its own kernel, and all of them together are the profile.
#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, unpack_normal}
#import bevy_lean_deferred::lighting::subsurface_light::{
    Entry, MATERIALS, pack_entry, scattering_distance, unpack_entry,
}
#import bevy_lean_deferred::screen_space::subsurface::{
    bindings::{light_texture, normal_texture, scattered_texture, tiles, view},
    profile::{REACH, share_beyond},
    texel::{pixels_per_metre_at, texel_of, to_viewer},
}
#ifdef PICTURE
#import bevy_lean_deferred::lighting::subsurface_light::unpack_receiver
#import bevy_lean_deferred::screen_space::subsurface::bindings::{output_texture, picture_texture}
#else
#import bevy_lean_deferred::screen_space::subsurface::bindings::level_output
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

fn surface_at(place: vec2<i32>, entry: Entry) -> Surface {
    var surface: Surface;
    surface.entry = entry;
    let texel = f32(1u << view.level);
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

/// The mean of what light that has scattered in the coarser level has more than the texel's own, around a place of that level;
/// in w how much of what is there belongs to the surface.
fn mean_around(surface: Surface, place: vec2<i32>, at: vec2<f32>) -> vec4<f32> {
    let texel = f32(2u << view.level);
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
        let other = unpack_entry(textureLoad(scattered_texture, vec2<i32>(first + corner), 0).rg);
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
    let level = f32(view.level);
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
        let lean = surface.normal.xy - to_viewer(middle * f32(2u << view.level)).xy * surface.facing;
        let along = normalize(vec2(-lean.y, lean.x) * sign(view.pixels_per_metre));
        let offset = along * (0.5 * sqrt(width * width - 1.0));
        sum = mean_around(surface, place, middle + offset) + mean_around(surface, place, middle - offset);
    }
    return share_beyond(level, paths) * sum.rgb / max(sum.a, 1e-4);
}

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let texel = texel_of(workgroup.xy, invocation);
    if !texel.exists {
        return;
    }
    let words = textureLoad(light_texture, texel.place, 0).rg;
    var entry = unpack_entry(words);
    var added = vec3(0.0);
    if entry.material != 0u {
        added = added_at(texel.place, surface_at(texel.place, entry));
    }
#ifdef PICTURE
    // Where that is nothing, or not a number, the picture stays as it is.
    if any(added != vec3(0.0)) && all(abs(added) < vec3(1e30)) {
        let receiver = unpack_receiver(textureLoad(picture_texture, texel.place, 0));
        let color = receiver.color.rgb + receiver.leaving * added;
        let place = vec2<i32>(view.viewport_origin) + texel.place;
        textureStore(output_texture, place, vec4(color, receiver.color.a));
    }
#else
    entry.light += added;
    textureStore(level_output, texel.place, vec4(select(vec2(0u), pack_entry(entry), entry.material != 0u), 0u, 0u));
#endif
}
