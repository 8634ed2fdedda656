//! Words of scattered light, and the shares of levels: the shipped WGSL on the device against Rust.

use bevy::math::Vec3;
use kit::{
    compute::Compute,
    random::Random,
    reference::{
        effects::subsurface::profile::share_beyond,
        shader_library::layout::light::{pack_light, unpack_light},
    },
    shipped_wgsl,
};

const SHARE: &str = "
#import bevy_lean_deferred::effects::subsurface::profile::share_beyond
fn kernel(bits: array<u32, 4>) -> array<u32, 3> {
    let paths = bitcast<vec3<f32>>(vec3(bits[1], bits[2], bits[3]));
    let found = bitcast<vec3<u32>>(share_beyond(bitcast<f32>(bits[0]), paths));
    return array(found.x, found.y, found.z);
}";

#[test]
fn levels_have_the_same_shares() {
    let mut random = Random::new(3);
    let hostile = [0.0, 1e-30, 1e-6, 1.0, 1e6, f32::MAX];
    let mut inputs: Vec<[f32; 4]> = (0..10_000)
        .map(|_| {
            let level = (random.unit() * 7.0).floor();
            let [r, g, b] = [(); 3].map(|()| (random.unit() * 20.0 - 10.0).exp2());
            [level, r, g, b]
        })
        .collect();
    inputs.extend((0..7).flat_map(|level| hostile.map(|path| [level as f32, path, path, 1.0])));
    let words: Vec<[u32; 4]> = inputs.iter().map(|input| input.map(f32::to_bits)).collect();
    let modules = [shipped_wgsl!("effects/subsurface/profile.wgsl")];
    let outputs: Vec<[u32; 3]> = Compute::new().kernel(&modules, SHARE).run(&words);
    for ([level, r, g, b], found) in inputs.into_iter().zip(outputs) {
        let expected = share_beyond(level, Vec3::new(r, g, b));
        let found = Vec3::from_array(found.map(f32::from_bits));
        assert!(found.cmpge(Vec3::ZERO).all() && found.cmple(Vec3::ONE).all());
        let off = (found - expected).abs().max_element();
        assert!(
            off < 1e-4,
            "level {level}, {r} {g} {b}: {found}, {expected}"
        );
    }
}

const ENTRY: &str = "
#import bevy_lean_deferred::lighting::subsurface_light::{Entry, pack_entry, unpack_entry}
fn kernel(bits: array<u32, 5>) -> array<u32, 7> {
    let light = bitcast<vec3<f32>>(vec3(bits[2], bits[3], bits[4]));
    let material = bits[1] % 255u + 1u;
    let words = pack_entry(Entry(bitcast<f32>(bits[0]), material, light));
    let entry = unpack_entry(words);
    // Packing a second time changes nothing.
    let again = pack_entry(entry);
    let found = bitcast<vec3<u32>>(entry.light);
    return array(material, bitcast<u32>(entry.metres), entry.material, found.x, found.y, found.z, u32(all(again == words)));
}";

#[test]
fn entries_hold_what_they_should() {
    let mut random = Random::new(5);
    let inputs: Vec<([f32; 4], u32)> = (0..20_000)
        .map(|i| {
            let light = [(); 3].map(|()| random.unit() * (random.unit() * 20.0 - 10.0).exp2());
            let metres = (random.unit() * 40.0 - 20.0).exp2();
            // Behind the viewer too, as in orthographic views.
            let metres = if i % 7 == 0 { -metres } else { metres };
            ([metres, light[0], light[1], light[2]], random.bits() >> 15)
        })
        .collect();
    let words: Vec<[u32; 5]> = inputs
        .iter()
        .map(|([metres, r, g, b], arguments)| {
            let [metres, r, g, b] = [metres, r, g, b].map(|x| x.to_bits());
            [metres, *arguments, r, g, b]
        })
        .collect();
    let modules = [
        shipped_wgsl!("shader_library/layout.wgsl"),
        shipped_wgsl!("shader_library/layout/light.wgsl"),
        shipped_wgsl!("shading_models/subsurface.wgsl"),
        shipped_wgsl!("lighting/subsurface_light.wgsl"),
    ];
    let outputs: Vec<[u32; 7]> = Compute::new().kernel(&modules, ENTRY).run(&words);
    for (([metres, r, g, b], _), found) in inputs.into_iter().zip(outputs) {
        let [material, at, stored, x, y, z, stays] = found;
        assert!((1..=255).contains(&material) && stored == material && stays == 1);
        let at = f32::from_bits(at);
        assert!(
            (at / metres - 1.0).abs() <= 1.0 / 65_536.0,
            "{metres}: {at}"
        );
        let expected = unpack_light(pack_light(Vec3::new(r, g, b)));
        let light = Vec3::from_array([x, y, z].map(f32::from_bits));
        assert_eq!(light, expected);
    }
}
