//! Words of cells, and mirror lobes: the shipped WGSL on the device against its Rust twins.

use bevy::math::{Vec2, Vec3};
use kit::{
    analytic_mirrors::sent_on,
    compute::Compute,
    random::Random,
    reference::shader_library::{
        cell::{pack_cell, unpack_cell},
        ggx::sample_lobe,
    },
    shipped_wgsl,
    skipped::on_swiftshader,
    wgsl::WgslModule,
};

const CELL: WgslModule = shipped_wgsl!("shader_library/cell.wgsl");
const GGX: WgslModule = shipped_wgsl!("shader_library/ggx.wgsl");

const PACK: &str = "
#import bevy_lean_deferred::cell::{pack_cell, unpack_cell}
fn kernel(bits: array<u32, 2>) -> array<u32, 3> {
    let word = pack_cell(bitcast<f32>(bits[0]), bitcast<f32>(bits[1]));
    let depths = unpack_cell(word);
    return array(word, bitcast<u32>(depths.x), bitcast<u32>(depths.y));
}";

const SAMPLE: &str = "
#import bevy_lean_deferred::ggx::sample_lobe
fn kernel(bits: array<u32, 6>) -> array<u32, 5> {
    let found = sample_lobe(
        bitcast<vec3<f32>>(vec3(bits[0], bits[1], bits[2])),
        bitcast<f32>(bits[3]),
        bitcast<vec2<f32>>(vec2(bits[4], bits[5])),
    );
    let d = bitcast<vec3<u32>>(found.direction);
    return array(d.x, d.y, d.z, bitcast<u32>(found.weight), bitcast<u32>(found.density));
}";

#[test]
fn cells_hold_all_of_their_depths() {
    let mut random = Random::new(11);
    let mut depths: Vec<[f32; 2]> = (0..20_000)
        .map(|_| [(); 2].map(|()| (random.unit() * 31.0).exp2().recip()))
        .collect();
    let hostile = [
        0.0,
        -0.0,
        -1.0,
        1e-45,
        1e-30,
        2.4e-10,
        1.0,
        1.0 - f32::EPSILON,
        2.0,
        1e30,
    ];
    depths.extend(hostile.iter().flat_map(|a| hostile.map(|b| [*a, b])));
    let inputs: Vec<[u32; 2]> = depths.iter().map(|pair| pair.map(f32::to_bits)).collect();
    let outputs: Vec<[u32; 3]> = Compute::new().kernel(&[CELL], PACK).run(&inputs);
    for (pair, [word, nearest, furthest]) in depths.iter().zip(outputs) {
        let [a, b] = *pair;
        assert_eq!(word, pack_cell(a, b), "{pair:?}");
        let unpacked = unpack_cell(word);
        assert_eq!(unpacked.map(f32::to_bits), [nearest, furthest], "{pair:?}");
        let [nearest, furthest] = unpacked;
        if (2.4e-10..=1.0).contains(&a) {
            assert!(nearest >= a && nearest < a * 1.000_5, "{a} as {nearest}");
        }
        if (2.4e-10..=1.0).contains(&b) {
            assert!(furthest <= b && furthest > b * 0.999_5, "{b} as {furthest}");
        }
    }
}

#[test]
fn lobes_are_their_twins() {
    let mut random = Random::new(7);
    let inputs: Vec<[f32; 6]> = (0..20_000)
        .map(|i| {
            let turn = random.unit() * core::f32::consts::TAU;
            let cosine = random.unit().max(1e-3);
            let sine = (1.0 - cosine * cosine).sqrt();
            let alpha = if i % 10 == 0 { 0.0 } else { random.unit() };
            [
                sine * turn.cos(),
                sine * turn.sin(),
                cosine,
                alpha,
                random.unit(),
                random.unit(),
            ]
        })
        .collect();
    let bits: Vec<[u32; 6]> = inputs.iter().map(|input| input.map(f32::to_bits)).collect();
    let outputs: Vec<[u32; 5]> = Compute::new().kernel(&[GGX], SAMPLE).run(&bits);
    let most = on_swiftshader(0.012, 2e-3, "lobes, by sines that are 5e-5 off");
    let least = on_swiftshader(0.02, 1e-3, "lobes near the horizon, by such sines");
    let mut largest = 0.0_f32;
    for ([x, y, z, alpha, u, v], output) in inputs.iter().zip(outputs) {
        let twin = sample_lobe(Vec3::new(*x, *y, *z), *alpha, Vec2::new(*u, *v));
        let [dx, dy, dz, weight, density] = output.map(f32::from_bits);
        let direction = Vec3::new(dx, dy, dz);
        largest = largest.max(direction.distance(twin.direction));
        // At the horizon one may be above it and the other below.
        if twin.direction.z.abs() > least {
            assert!((weight - twin.weight).abs() < most, "{weight}, {twin:?}");
            let ratio = density / twin.density;
            assert!(
                (0.95..1.05).contains(&ratio) || density > 1e4,
                "{density}, {twin:?}"
            );
        }
        assert!((0.0..=1.000_1).contains(&weight) && density > 0.0);
        // A perfect mirror has a single direction, not a hemisphere of them.
        assert!(*alpha > 0.0 || density > 1e4, "{density}");
    }
    assert!(largest < most, "{largest}");
}

/// The mean weight equals the directional albedo of a rough metal.
#[test]
fn lobes_send_on_what_the_integral_says() {
    for roughness in [0.2, 0.4, 0.6, 0.8, 1.0_f32] {
        for cosine in [0.1, 0.3, 0.6, 0.9_f32] {
            let view = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
            let side = 200;
            let weights = (0..side * side).map(|i| {
                let u = (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5) / side as f32;
                sample_lobe(view, roughness * roughness, u).weight
            });
            let mean = weights.sum::<f32>() / (side * side) as f32;
            let exact = sent_on(cosine, roughness);
            assert!(
                (mean - exact).abs() < 0.01,
                "{roughness}, {cosine}: {mean}, {exact}"
            );
        }
    }
}
