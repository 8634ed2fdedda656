// Light that has scattered beneath the surface of each pixel: samples of the profile on its tangent plane, each the mean light
// of the part of the surface that it stands for.
#import bevy_lean_deferred::lighting::subsurface_light::{
    Receiver, material_of, scattering_distance, unpack_entry, unpack_receiver,
}
#import bevy_lean_deferred::pattern::turn_of
#import bevy_lean_deferred::screen_space::subsurface::{
    bindings::{light_texture, picture_texture, view},
    output::add_scattered,
    profile::sample_of,
    surface::{belongs, is_in_view, pixel_of, pixels_per_metre_at, surface_at},
    tile::{NO_MATERIAL, next_material, tile_of},
}

const PI_2: f32 = 6.28318530717959;
/// Of a pixel: a multiple of the number of channels.
const SAMPLES: u32 = #{SAMPLES}u;
/// Samples of pixels beside one another are at different radii.
const SETS: u32 = 4u;
const COARSEST: f32 = 3.0;

/// Radius and weights of each sample of a material.
var<workgroup> samples: array<vec4<f32>, #{SAMPLES_OF_SETS}>;
/// The level whose texels are as large as what a sample stands for, in views where a pixel is a metre.
var<workgroup> levels: array<f32, #{SAMPLES_OF_SETS}>;

fn prepare_samples(arguments: u32, invocation: u32) {
    let paths = scattering_distance(arguments);
    for (var i = invocation; i < SAMPLES * SETS; i += 64u) {
        let index = i % SAMPLES;
        let channel = index % 3u;
        // Each channel's strata are sampled elsewhere, so that equal ones have three times as many.
        let jitter = fract((f32(channel) + 0.5) / 3.0 + f32(i / SAMPLES) / f32(SETS));
        let sample = sample_of(paths, channel, (f32(index / 3u) + jitter) / f32(SAMPLES / 3u));
        samples[i] = vec4(sample.radius, sample.weights);
        levels[i] = 0.5 * log2(sample.area / f32(SAMPLES));
    }
}

/// What scattering adds to the light that enters at a pixel.
fn gather(pixel: vec2<i32>, receiver: Receiver) -> vec3<f32> {
    let material = material_of(receiver.arguments);
    let surface = surface_at(pixel, scattering_distance(receiver.arguments));
    let own = unpack_entry(textureLoad(light_texture, pixel, 0).rg).light;
    // Texels of the plane are as much smaller as it is turned away.
    let scale = surface.shrink * pixels_per_metre_at(-surface.position.z);
    let facing = abs(dot(surface.normal, normalize(surface.position)));
    let finest = log2(max(scale * sqrt(facing), 1e-30));
    let tangent = normalize(surface.right);
    let bitangent = cross(surface.normal, tangent);
    let turn = turn_of(vec2<u32>(pixel) & vec2(3u));
    let first = (turn & (SETS - 1u)) * SAMPLES;
    let turned = f32(turn) / 16.0 + view.turn;
    var sum = vec3(0.0);
    var weights = vec3(0.0);
    for (var i = 0u; i < SAMPLES; i++) {
        let sample = samples[first + i];
        let radius = sample.x * surface.shrink;
        // The golden section spreads any number of samples.
        let angle = PI_2 * fract(turned + 0.618034 * f32(i));
        let away = (tangent * cos(angle) + bitangent * sin(angle)) * radius;
        let at = pixel_of(surface.position + away);
        let level = i32(clamp(levels[first + i] + finest, 0.0, COARSEST));
        let texel = vec2<i32>(at) >> vec2(u32(level));
        let entry = unpack_entry(textureLoad(light_texture, texel, level).rg);
        let center = (vec2<f32>(texel) + 0.5) * f32(1u << u32(level));
        let weight = sample.yzw * select(0.0, belongs(surface, material, entry, center, radius), is_in_view(at));
        // Of the difference: where there is none, nothing changes.
        sum += weight * (entry.light - own);
        weights += weight;
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
    if textureLoad(light_texture, pixel, 0).r != 0u {
        receiver = unpack_receiver(textureLoad(picture_texture, pixel, 0));
        arguments = receiver.arguments;
    }
    loop {
        let material = next_material(arguments, invocation);
        if material == NO_MATERIAL {
            break;
        }
        prepare_samples(material, invocation);
        workgroupBarrier();
        if arguments == material {
            add_scattered(pixel, receiver, gather(pixel, receiver));
            arguments = NO_MATERIAL;
        }
        workgroupBarrier();
    }
}
