//! The weights with which surfaces are those of the last frame, and the words of GI's levels: the shipped WGSL on the device against its
//! Rust twins.

use bevy::math::{Vec2, Vec4};
use kit::{
    compute::Compute,
    random::Random,
    reference::effects::{
        diffuse_gi::entry::{PIXEL, pack_depth, unpack_depth, unpack_known, unpack_pixel},
        reprojection::{filled_up, own_motion, weight_of_match},
    },
    shipped_wgsl,
    wgsl::WgslModule,
};

const REPROJECTION: WgslModule = shipped_wgsl!("effects/reprojection.wgsl");
const ENTRY: [WgslModule; 3] = [
    shipped_wgsl!("shader_library/layout.wgsl"),
    shipped_wgsl!("shader_library/layout/light.wgsl"),
    shipped_wgsl!("effects/diffuse_gi/entry.wgsl"),
];

const WEIGH: &str = "
#import bevy_lean_deferred::effects::reprojection::{filled_up, own_motion, weight_of_match}
fn kernel(bits: array<u32, 12>) -> array<u32, 6> {
    let a = bitcast<vec4<f32>>(vec4(bits[0], bits[1], bits[2], bits[3]));
    let b = bitcast<vec4<f32>>(vec4(bits[4], bits[5], bits[6], bits[7]));
    let c = bitcast<vec4<f32>>(vec4(bits[8], bits[9], bits[10], bits[11]));
    let weight = weight_of_match(a.x, a.y, a.z, a.w);
    let own = own_motion(b.xy, b.zw, c.xy);
    let light = bitcast<vec4<u32>>(filled_up(vec4(b.xyz, a.w), vec4(c.xyz, c.w)));
    return array(bitcast<u32>(weight), bitcast<u32>(own), light.x, light.y, light.z, light.w);
}";

const PACK: &str = "
#import bevy_lean_deferred::effects::diffuse_gi::entry::{pack_depth, unpack_depth, unpack_known, unpack_pixel}
fn kernel(bits: array<u32, 2>) -> array<u32, 4> {
    // The weight chooses the pixel.
    let word = pack_depth(bitcast<f32>(bits[0]), bitcast<f32>(bits[1]), u32(4.0 * bitcast<f32>(bits[1])) & 3u);
    return array(word, bitcast<u32>(unpack_depth(word)), bitcast<u32>(unpack_known(word)), unpack_pixel(word));
}";

fn is_near(found: f32, expected: f32) -> bool {
    (found - expected).abs() <= 1e-4 * expected.abs() + 1e-6
}

#[test]
fn weights_are_their_twins() {
    let mut random = Random::new(3);
    let inputs: Vec<[f32; 12]> = (0..20_000)
        .map(|_| [(); 12].map(|()| random.unit()))
        .collect();
    let bits: Vec<[u32; 12]> = inputs.iter().map(|input| input.map(f32::to_bits)).collect();
    let outputs: Vec<[u32; 6]> = Compute::new().kernel(&[REPROJECTION], WEIGH).run(&bits);
    for (input, output) in inputs.iter().zip(outputs) {
        let [a, b, c] = [0, 4, 8].map(|i| Vec4::from_slice(&input[i..i + 4]));
        let weight = weight_of_match(a.x, a.y, a.z, a.w);
        let own = own_motion(
            Vec2::new(b.x, b.y),
            Vec2::new(b.z, b.w),
            Vec2::new(c.x, c.y),
        );
        let light = filled_up(b.truncate().extend(a.w), c);
        let [found, rest @ ..] = output.map(f32::from_bits);
        // A quotient of small tolerances.
        assert!(
            (found - weight).abs() < 1e-3,
            "{input:?}: {found}, {weight}"
        );
        let expected = [own, light.x, light.y, light.z, light.w];
        for (found, expected) in rest.into_iter().zip(expected) {
            assert!(is_near(found, expected), "{input:?}: {found}, {expected}");
        }
    }
}

/// Surfaces at rest, those that move with the camera, and all between the two are found; others fade out without a step.
#[test]
fn weights_have_no_steps() {
    let tolerance = 0.01;
    for (at_rest, with_view) in [(0.6, 0.5), (0.5, 0.6), (0.5, 0.5)] {
        for share in [0.0, 0.3, 1.0] {
            let kept = at_rest + share * (with_view - at_rest);
            assert_eq!(weight_of_match(kept, at_rest, with_view, tolerance), 1.0);
        }
        let mut before = 0.0;
        for i in 0..=1000 {
            let weight = weight_of_match(0.4 + 0.0003 * i as f32, at_rest, with_view, tolerance);
            assert!(f32::abs(weight - before) <= 0.0301, "{i}");
            before = weight;
        }
        assert_eq!(weight_of_match(0.47, at_rest, with_view, tolerance), 0.0);
        assert_eq!(weight_of_match(0.63, at_rest, with_view, tolerance), 0.0);
    }
}

#[test]
fn words_keep_depth_and_weight() {
    let mut random = Random::new(13);
    let mut inputs: Vec<[f32; 2]> = (0..20_000)
        .map(|_| [(random.unit() * 62.0).exp2().recip(), random.unit()])
        .collect();
    let hostile = [
        0.0,
        -0.0,
        -1.0,
        1e-30,
        f32::from_bits(0x2000_0000),
        1.0,
        1.0 - f32::EPSILON,
        2.0,
        f32::INFINITY,
        f32::NAN,
    ];
    inputs.extend(
        hostile
            .iter()
            .flat_map(|depth| [0.0, 0.5, 1.0].map(|known| [*depth, known])),
    );
    let bits: Vec<[u32; 2]> = inputs.iter().map(|input| input.map(f32::to_bits)).collect();
    let outputs: Vec<[u32; 4]> = Compute::new().kernel(&ENTRY, PACK).run(&bits);
    for ([depth, known], [word, unpacked, weight, number]) in inputs.into_iter().zip(outputs) {
        let pixel = (4.0 * known) as u32 & 3;
        // NaN may become any number on a device.
        if depth.is_nan() {
            assert_eq!(pack_depth(depth, known, pixel), 0);
            continue;
        }
        assert_eq!(word, pack_depth(depth, known, pixel), "{depth:?}, {known}");
        assert_eq!(unpacked, unpack_depth(word).to_bits());
        assert!(is_near(f32::from_bits(weight), unpack_known(word)));
        if depth <= 0.0 {
            assert_eq!(word, 0, "{depth:?}");
        } else if (2e-19..=1.0).contains(&depth) {
            assert_eq!(unpacked | PIXEL, depth.to_bits() | PIXEL, "{depth:?}");
        }
        if depth > 0.0 {
            assert!(unpack_pixel(word) == pixel && number == pixel);
        }
        if depth > 0.0 && depth.is_finite() {
            let off = (f32::from_bits(weight) - known).abs();
            assert!(off < 0.0715 && f32::from_bits(unpacked) > 0.0, "{known}");
        }
    }
}
