// The cheaper form (Jimenez et al. 2015, "Separable Subsurface Scattering"): light that has scattered along rows, then along
// columns, by what of the profile leaves beside a line.
#import bevy_lean_deferred::lighting::subsurface_light::{
    Receiver, material_of, scattering_distance, unpack_entry, unpack_receiver,
}
#import bevy_lean_deferred::gbuffer::layout::light::{pack_light, unpack_light}
#import bevy_lean_deferred::pattern::turn_of
#import bevy_lean_deferred::screen_space::subsurface::{
    bindings::{light_texture, picture_texture, view},
    profile::{REACH, SHORTEST, share_beside},
    surface::{belongs, is_in_view, surface_at},
    tile::{NO_MATERIAL, next_material, tile_of},
}
#ifdef ACROSS
#import bevy_lean_deferred::screen_space::subsurface::bindings::across_output
#else
#import bevy_lean_deferred::screen_space::subsurface::bindings::across_texture
#import bevy_lean_deferred::screen_space::subsurface::output::add_scattered
#endif

/// On each side.
const SAMPLES: i32 = 8;

/// Of the strip at the pixel and those beside it: how far away they end, and what of the light leaves there; of both sides
/// together.
var<workgroup> strips: array<vec4<f32>, 9>;

/// Where a strip ends, in the longest mean free paths.
fn end_of(strip: i32) -> f32 {
    let share = (f32(strip) + 0.5) / (f32(SAMPLES) + 0.5);
    return REACH * share * share;
}

fn shares_within(paths_away: f32, ratios: vec3<f32>) -> vec3<f32> {
    let away = paths_away * ratios;
    return vec3(share_beside(away.r), share_beside(away.g), share_beside(away.b));
}

fn prepare_strips(arguments: u32, invocation: u32) {
    let strip = i32(invocation);
    if strip > SAMPLES {
        return;
    }
    let paths = max(scattering_distance(arguments), vec3(SHORTEST));
    let ratios = max(paths.r, max(paths.g, paths.b)) / paths;
    var shares = shares_within(end_of(strip), ratios);
    if strip > 0 {
        shares -= shares_within(end_of(strip - 1), ratios);
    }
    strips[invocation] = vec4(end_of(strip), shares);
}

/// The light of a pixel, as far as this pass has it.
fn light_at(pixel: vec2<i32>, word: u32) -> vec3<f32> {
#ifdef ACROSS
    return unpack_light(word);
#else
    return unpack_light(textureLoad(across_texture, pixel, 0).r);
#endif
}

/// What scattering along a line adds to the light of a pixel.
fn gather(pixel: vec2<i32>, receiver: Receiver, own: vec3<f32>) -> vec3<f32> {
    let material = material_of(receiver.arguments);
    let surface = surface_at(pixel, scattering_distance(receiver.arguments));
#ifdef ACROSS
    let along = vec2(1.0, 0.0);
    let step = length(surface.right);
#else
    let along = vec2(0.0, 1.0);
    let step = length(surface.down);
#endif
    let scale = surface.shrink * surface.path;
    // Each pixel looks elsewhere within the strips.
    let turn = fract((f32(turn_of(vec2<u32>(pixel) & vec2(3u))) + 0.5) / 16.0 + view.turn);
    var sum = vec3(0.0);
    var weights = strips[0].yzw;
    for (var i = 1; i <= SAMPLES; i++) {
        let strip = strips[i];
        let radius = mix(strips[i - 1].x, strip.x, turn) * scale;
        for (var side = -1.0; side < 2.0; side += 2.0) {
            let at = vec2<f32>(pixel) + 0.5 + along * (side * radius / step);
            let place = vec2<i32>(floor(at));
            let words = textureLoad(light_texture, place, 0).rg;
            let entry = unpack_entry(words);
            let center = vec2<f32>(place) + 0.5;
            let is_beside = select(0.0, belongs(surface, material, entry, center, radius), is_in_view(at));
            let weight = 0.5 * strip.yzw * is_beside;
            sum += weight * (light_at(place, words.y) - own);
            weights += weight;
        }
    }
    return sum / max(weights, vec3(1e-6));
}

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let tile = tile_of(workgroup.xy);
    if !tile.is_listed {
        return;
    }
    let pixel = vec2<i32>(tile.origin + vec2(invocation & 7u, invocation >> 3u));
    var receiver: Receiver;
    var arguments = NO_MATERIAL;
    let words = textureLoad(light_texture, pixel, 0).rg;
    if words.x != 0u {
        receiver = unpack_receiver(textureLoad(picture_texture, pixel, 0));
        arguments = receiver.arguments;
    }
    loop {
        let material = next_material(arguments, invocation);
        if material == NO_MATERIAL {
            break;
        }
        prepare_strips(material, invocation);
        workgroupBarrier();
        if arguments == material {
            let own = light_at(pixel, words.y);
            let added = gather(pixel, receiver, own);
#ifdef ACROSS
            textureStore(across_output, pixel, vec4(pack_light(own + added)));
#else
            add_scattered(pixel, receiver, own + added - unpack_light(words.y));
#endif
            arguments = NO_MATERIAL;
        }
        workgroupBarrier();
    }
}
