//! Distance fog: the shipped WGSL on the device against its Rust twin, and its rules.

use bevy::{math::Vec3, pbr::FogFalloff, prelude::*};
use kit::{
    compute::Compute,
    random::Random,
    reference::shader_library::distance_fog::{
        FogUniform, LEAST_TRANSMITTANCE, fog_light, fogged_in_mirror, transmittance, without_fog,
    },
    shipped_wgsl,
    wgsl::WgslModule,
};

const DISTANCE_FOG: WgslModule = shipped_wgsl!("shader_library/distance_fog.wgsl");

/// Fog, light, three distances and a ratio of exposures to light without fog, and in a mirror.
const KERNEL: &str = "
#import bevy_lean_deferred::distance_fog::{FogUniform, fogged_in_mirror, without_fog}
fn floats(bits: vec3<u32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(bits);
}
fn kernel(bits: array<u32, 18>) -> array<u32, 6> {
    let fog = FogUniform(
        vec4(floats(vec3(bits[0], bits[1], bits[2])), bitcast<f32>(bits[3])),
        floats(vec3(bits[4], bits[5], bits[6])),
        bits[7],
        floats(vec3(bits[8], bits[9], bits[10])),
    );
    let seen = floats(vec3(bits[11], bits[12], bits[13]));
    let metres = floats(vec3(bits[14], bits[15], bits[16]));
    let light = without_fog(fog, seen, metres.x, bitcast<f32>(bits[17]));
    let a = bitcast<vec3<u32>>(light);
    let b = bitcast<vec3<u32>>(fogged_in_mirror(fog, light, metres.y, metres.z));
    return array(a.x, a.y, a.z, b.x, b.y, b.z);
}";

/// Fogs of all kinds.
fn fogs(random: &mut Random) -> Vec<FogUniform> {
    let density = |random: &mut Random| 10.0_f32.powf(random.unit() * 3.0 - 4.0);
    let mut found = Vec::new();
    for i in 0..400 {
        let falloff = match i % 4 {
            0 => FogFalloff::Linear {
                start: 20.0 * random.unit(),
                end: 21.0 + 100.0 * random.unit(),
            },
            1 => FogFalloff::Exponential {
                density: density(random),
            },
            2 => FogFalloff::ExponentialSquared {
                density: density(random),
            },
            _ => FogFalloff::Atmospheric {
                extinction: Vec3::from_array([(); 3].map(|()| density(random))),
                inscattering: Vec3::from_array([(); 3].map(|()| density(random))),
            },
        };
        let alpha = if i % 3 == 0 { random.unit() } else { 1.0 };
        let [red, green, blue] = [(); 3].map(|()| random.unit());
        found.push(FogUniform::new(Some(&DistanceFog {
            color: Color::linear_rgba(red, green, blue, alpha),
            falloff,
            ..default()
        })));
    }
    found
}

#[test]
fn fog_is_its_twin() {
    let mut random = Random::new(23);
    let mut inputs = Vec::new();
    let mut twins = Vec::new();
    for fog in fogs(&mut random) {
        for _ in 0..10 {
            let seen = Vec3::from_array([(); 3].map(|()| 4.0 * random.unit()));
            let [direct, to_mirror, between] = [(); 3].map(|()| 150.0 * random.unit());
            let (path, ratio) = (to_mirror + between, 0.5 + random.unit());
            let mut words = [0; 18];
            words[..4].copy_from_slice(&fog.color.to_array().map(f32::to_bits));
            words[4..7].copy_from_slice(&fog.extinction.to_array().map(f32::to_bits));
            words[7] = fog.mode;
            words[8..11].copy_from_slice(&fog.inscattering.to_array().map(f32::to_bits));
            words[11..14].copy_from_slice(&seen.to_array().map(f32::to_bits));
            words[14..].copy_from_slice(&[direct, to_mirror, path, ratio].map(f32::to_bits));
            inputs.push(words);
            let light = without_fog(&fog, seen, direct, ratio);
            twins.push([light, fogged_in_mirror(&fog, light, to_mirror, path)]);
        }
    }
    let outputs: Vec<[u32; 6]> = Compute::new().kernel(&[DISTANCE_FOG], KERNEL).run(&inputs);
    for ((words, twin), output) in inputs.iter().zip(twins).zip(outputs) {
        let found = output.map(f32::from_bits);
        let expected = [twin[0].to_array(), twin[1].to_array()].concat();
        for (found, expected) in found.iter().zip(expected) {
            // Differences of fog are divided by as little as `LEAST_TRANSMITTANCE`, twice.
            let most = 1e-3 * expected.abs() + 4e-6 / LEAST_TRANSMITTANCE / LEAST_TRANSMITTANCE;
            assert!(
                (found - expected).abs() < most,
                "{words:?}: {output:?}, {twin:?}"
            );
        }
    }
}

/// A picture behind fog, without it again, in a mirror, and behind the fog in front of the mirror: fog of the path alone is left.
#[test]
fn mirrored_light_has_the_fog_of_its_path_once() {
    let mut random = Random::new(29);
    let mut count = 0;
    for fog in fogs(&mut random) {
        let light = Vec3::from_array([(); 3].map(|()| random.unit()));
        // Corners of a triangle: the viewer, the mirror and the surface.
        let [mirror, surface] =
            [(); 2].map(|()| Vec3::from_array([(); 3].map(|()| 40.0 * random.unit())));
        let (direct, to_mirror) = (surface.length(), mirror.length());
        let path = to_mirror + surface.distance(mirror);
        let behind =
            |light: Vec3, metres| light * transmittance(&fog, metres) + fog_light(&fog, metres);
        let least = [direct, to_mirror].map(|metres| transmittance(&fog, metres).min_element());
        if least[0].min(least[1]) < LEAST_TRANSMITTANCE {
            continue;
        }
        count += 1;
        let seen = behind(light, direct);
        let received = without_fog(&fog, seen, direct, 1.0);
        assert!(received.distance(light) < 1e-3, "{fog:?}: {received}");
        let shown = behind(fogged_in_mirror(&fog, received, to_mirror, path), to_mirror);
        let truth = behind(light, path);
        assert!(shown.distance(truth) < 1e-4, "{fog:?}: {shown}, {truth}");
    }
    assert!(count > 200, "{count}");
}
