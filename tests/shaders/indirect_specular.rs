//! Words of what pixels mirror: the shipped WGSL on the device beside Rust.

use bevy::math::{UVec2, Vec4, Vec4Swizzles};
use bevy_lean_deferred::shader_library::layout::{
    indirect_specular::{
        confidence_of, confidence_place, light_place, pack_specular, place_in_square, texture_size,
    },
    light::unpack_light,
};
use kit::{compute::Compute, random::Random, shipped_wgsl, wgsl::WgslModule};

const MODULES: [WgslModule; 3] = [
    shipped_wgsl!("shader_library/layout.wgsl"),
    shipped_wgsl!("shader_library/layout/light.wgsl"),
    shipped_wgsl!("shader_library/layout/indirect_specular.wgsl"),
];

const PLACES: &str = "
#import bevy_lean_deferred::gbuffer::layout::indirect_specular as specular
fn kernel(pixel: array<u32, 2>) -> array<u32, 7> {
    let at = vec2(pixel[0], pixel[1]);
    let light = specular::light_place(at);
    let confidence = specular::confidence_place(at);
    let size = specular::texture_size(at);
    return array(light.x, light.y, confidence.x, confidence.y, specular::place_in_square(at), size.x, size.y);
}";

#[test]
fn pixels_have_the_same_places() {
    let mut random = Random::new(7);
    let random_side = |random: &mut Random| random.bits() >> 18;
    let mut pixels: Vec<[u32; 2]> = (0..48 * 48).map(|i| [i % 48, i / 48]).collect();
    pixels.extend((0..50_000).map(|_| [(); 2].map(|()| random_side(&mut random))));
    let found: Vec<[u32; 7]> = Compute::new().kernel(&MODULES, PLACES).run(&pixels);
    for (pixel, found) in pixels.into_iter().map(UVec2::from).zip(found) {
        let places = [light_place(pixel), confidence_place(pixel)];
        let expected: Vec<u32> = (places.iter().flat_map(|place| place.to_array()))
            .chain([place_in_square(pixel)])
            .chain(texture_size(pixel).to_array())
            .collect();
        assert_eq!(found[..], expected, "{pixel}");
    }
}

const CONFIDENCES: &str = "
#import bevy_lean_deferred::gbuffer::layout::indirect_specular::{confidence_of, pack_confidences}
fn kernel(bits: array<u32, 4>) -> array<u32, 1> {
    let confidence = confidence_of(bitcast<vec4<f32>>(vec4(bits[0], bits[1], bits[2], bits[3])));
    return array(pack_confidences(vec4(confidence, 0.0, 1.0, confidence)));
}";

#[test]
fn confidences_are_packed_alike_whatever_they_are() {
    let mut random = Random::new(8);
    let hostile = [
        f32::NAN,
        -f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        1e30,
        -1.0,
        -0.0,
        1e-45,
        1.0 / 510.0,
        1.0,
        1.5,
    ];
    let mut number = || match random.bits() % 3 {
        0 => hostile[random.bits() as usize % hostile.len()],
        1 => f32::from_bits(random.bits()),
        _ => random.unit(),
    };
    let texels: Vec<Vec4> = (0..100_000)
        .map(|_| Vec4::from_array([(); 4].map(|()| number())))
        .collect();
    let inputs: Vec<[u32; 4]> = texels
        .iter()
        .map(|texel| texel.to_array().map(f32::to_bits))
        .collect();
    let found: Vec<[u32; 1]> = Compute::new().kernel(&MODULES, CONFIDENCES).run(&inputs);
    for (texel, [found]) in texels.into_iter().zip(found) {
        let confidence = confidence_of(texel);
        // Drivers may round halves either way.
        let codes = [-1e-4, 1e-4].map(|off| (confidence * 255.0 + 0.5 + off) as u32);
        let code = found & 0xff;
        assert!(codes.contains(&code), "{texel}: {code}, expected {codes:?}");
        assert_eq!(found >> 8, 0xff00 | (code << 16), "{texel}");
    }
}

/// What the twin has packed is where it should be.
#[test]
fn a_texture_keeps_light_and_confidence() {
    let size = UVec2::new(37, 21);
    let texel = |pixel: UVec2| {
        let light = pixel.extend(1).as_vec3() / 37.0;
        light.extend(((pixel.x + pixel.y) % 5) as f32 / 4.0)
    };
    let words = pack_specular(size, texel);
    let width = texture_size(size).x;
    let word = |place: UVec2| words[(place.x + width * place.y) as usize];
    for i in 0..size.element_product() {
        let pixel = UVec2::new(i % size.x, i / size.x);
        let expected = texel(pixel);
        let light = unpack_light(word(light_place(pixel)));
        let step = expected.xyz().max_element() / 511.0;
        assert!((light - expected.xyz()).abs().max_element() <= step);
        let confidences = word(confidence_place(pixel)) >> (8 * place_in_square(pixel));
        let off = (confidences & 0xff) as f32 / 255.0 - expected.w;
        assert!(off.abs() <= 0.51 / 255.0, "{pixel}: off by {off}");
    }
}
