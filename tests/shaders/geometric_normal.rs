//! Geometric normals from depth: the shipped WGSL on the device beside its Rust twin, and how exact they are on
//! surfaces with known normals.

mod accuracy;
mod scenes;

use bevy::math::{DVec3, IVec2, Vec3};
use bevy_lean_deferred::shader_library::reconstruction::normal::{
    nearer_side, normal_from_positions, straighter_side,
};
use kit::{
    compute::{Compute, WgslModule},
    random::Random,
};
use scenes::{HEIGHT, Lens, WIDTH};

const MODULE: WgslModule = WgslModule {
    path: "src/shader_library/reconstruction/normal.wgsl",
    source: include_str!("../../src/shader_library/reconstruction/normal.wgsl"),
};

const SIDES: &str = "
#import bevy_lean_deferred::reconstruction::normal::{nearer_side, straighter_side}
fn kernel(bits: array<u32, 5>) -> array<u32, 2> {
    let center = bitcast<f32>(bits[0]);
    let near_a = bitcast<f32>(bits[1]);
    let far_a = bitcast<f32>(bits[2]);
    let near_b = bitcast<f32>(bits[3]);
    let far_b = bitcast<f32>(bits[4]);
    return array(
        bitcast<u32>(nearer_side(center, near_a, near_b)),
        bitcast<u32>(straighter_side(center, near_a, far_a, near_b, far_b)),
    );
}";

const NORMALS: &str = "
#import bevy_lean_deferred::reconstruction::normal::normal_from_positions
fn kernel(bits: array<u32, 11>) -> array<u32, 3> {
    let n = bitcast<vec3<u32>>(normal_from_positions(
        bitcast<vec3<f32>>(vec3(bits[0], bits[1], bits[2])),
        bitcast<vec3<f32>>(vec3(bits[3], bits[4], bits[5])),
        bitcast<f32>(bits[6]),
        bitcast<vec3<f32>>(vec3(bits[7], bits[8], bits[9])),
        bitcast<f32>(bits[10]),
    ));
    return array(n.x, n.y, n.z);
}";

fn bits<const N: usize>(inputs: &[[f32; N]]) -> Vec<[u32; N]> {
    inputs.iter().map(|input| input.map(f32::to_bits)).collect()
}

#[test]
fn device_and_twin_choose_the_same_sides() {
    const HOSTILE: [f32; 9] = [
        0.0,
        1e-30,
        1e-7,
        0.5,
        1.0,
        1e30,
        -1.0,
        f32::INFINITY,
        f32::NAN,
    ];
    let mut random = Random::new(1);
    let mut inputs: Vec<[f32; 5]> = (0..HOSTILE.len().pow(5))
        .map(|i| [1, 9, 81, 729, 6561].map(|place| HOSTILE[i / place % 9]))
        .collect();
    inputs.extend((0..500_000).map(|_| {
        let center = 10f32.powf(random.range(-6.0, 0.0));
        [(); 5].map(|()| center * (1.0 + random.range(-0.1, 0.1)))
    }));

    let compute = Compute::new();
    let kernel = compute.kernel(&[MODULE], SIDES);
    for (&input, device) in inputs.iter().zip(kernel.run(&bits(&inputs))) {
        let [center, near_a, far_a, near_b, far_b] = input;
        let twin = [
            nearer_side(center, near_a, near_b),
            straighter_side(center, near_a, far_a, near_b, far_b),
        ];
        assert_eq!(device.map(f32::from_bits), twin, "of {input:?}");
    }
}

/// How far `normal_from_positions` may be off, in radians, only because positions are f32: the tangents are differences
/// of positions, their product is small where they are nearly parallel.
fn rounding_of_normal([cx, cy, cz, hx, hy, hz, _, vx, vy, vz, _]: [f32; 11]) -> f64 {
    let center = DVec3::new(cx.into(), cy.into(), cz.into());
    let h = DVec3::new(hx.into(), hy.into(), hz.into()) - center;
    let v = DVec3::new(vx.into(), vy.into(), vz.into()) - center;
    4.0 * f64::from(f32::EPSILON) * h.length() * v.length() / h.cross(v).length()
}

/// Triples of positions a pixel apart, and up to as far as a silhouette's background; some on one line.
fn random_positions(count: usize) -> Vec<[f32; 11]> {
    let mut random = Random::new(2);
    (0..count)
        .map(|i| {
            let mut sign = || if random.bits() & 1 == 0 { -1.0 } else { 1.0 };
            let (horizontal_side, vertical_side) = (sign(), sign());
            let distance = 10f32.powf(random.range(-1.0, 4.0));
            let far = if i % 5 == 0 {
                random.range(1.0, 1e6)
            } else {
                1.0
            };
            let mut vector = |scale: f32| {
                let mut component = || random.range(-scale, scale);
                Vec3::new(component(), component(), component())
            };
            let center = vector(distance);
            let h = vector(0.01 * distance * far) * horizontal_side;
            let v = if i % 11 == 0 {
                h * vertical_side
            } else {
                vector(0.01 * distance)
            };
            let (h, v) = (center + h, center + v);
            let c = center;
            [
                c.x,
                c.y,
                c.z,
                h.x,
                h.y,
                h.z,
                horizontal_side,
                v.x,
                v.y,
                v.z,
                vertical_side,
            ]
        })
        .collect()
}

/// Positions of any three neighbouring pixels, with depths that have nothing to do with each other.
fn positions_of_any_depths(count: usize) -> Vec<[f32; 11]> {
    const DEPTHS: [f32; 9] = [0.0, 1e-45, 1e-30, 1e-20, 1e-7, 0.3, 0.3 + 1e-7, 0.7, 1.0];
    let mut random = Random::new(3);
    (0..count)
        .map(|_| {
            let lens = Lens::ALL[random.below(2)];
            let mut side = || if random.bits() & 1 == 0 { -1 } else { 1 };
            let (h_side, v_side) = (side(), side());
            let middle = IVec2::new(WIDTH, HEIGHT) / 2;
            let pixel = match random.below(3) {
                0 => middle,
                1 => middle.with_x(0),
                _ => IVec2::new(random.below(640) as i32, random.below(480) as i32),
            };
            let mut position = |pixel| lens.position(pixel, DEPTHS[random.below(DEPTHS.len())]);
            let c = position(pixel);
            let h = position(pixel + IVec2::X * h_side);
            let v = position(pixel + IVec2::Y * v_side);
            [
                c.x,
                c.y,
                c.z,
                h.x,
                h.y,
                h.z,
                h_side as f32,
                v.x,
                v.y,
                v.z,
                v_side as f32,
            ]
        })
        .collect()
}

fn twin_normal([cx, cy, cz, hx, hy, hz, h_side, vx, vy, vz, v_side]: [f32; 11]) -> Vec3 {
    normal_from_positions(
        Vec3::new(cx, cy, cz),
        Vec3::new(hx, hy, hz),
        h_side,
        Vec3::new(vx, vy, vz),
        v_side,
    )
}

#[test]
fn device_and_twin_find_the_same_normals() {
    let compute = Compute::new();
    let kernel = compute.kernel(&[MODULE], NORMALS);
    let inputs = random_positions(500_000);
    let mut compared = 0;
    for (&input, device) in inputs.iter().zip(kernel.run(&bits(&inputs))) {
        let device = Vec3::from_array(device.map(f32::from_bits));
        let twin = twin_normal(input);
        for n in [device, twin] {
            assert!((n.length() - 1.0).abs() < 1e-6, "{input:?} gives {n}");
        }
        let tolerance = rounding_of_normal(input);
        if tolerance < 0.1 {
            compared += 1;
            let distance = f64::from(device.distance(twin));
            assert!(
                distance <= tolerance + 1e-6,
                "{input:?} gives {device}, not {twin}"
            );
        }
    }
    assert!(
        compared > inputs.len() * 4 / 5,
        "only {compared} of {} are no lines",
        inputs.len()
    );
}

#[test]
fn any_depths_give_unit_normals() {
    let compute = Compute::new();
    let kernel = compute.kernel(&[MODULE], NORMALS);
    let inputs = positions_of_any_depths(200_000);
    let (mut device_failures, mut twin_failures) = (Vec::new(), Vec::new());
    for (&input, device) in inputs.iter().zip(kernel.run(&bits(&inputs))) {
        let device = Vec3::from_array(device.map(f32::from_bits));
        for (n, failures) in [
            (device, &mut device_failures),
            (twin_normal(input), &mut twin_failures),
        ] {
            if (n.length() - 1.0).abs() >= 1e-6 || !n.is_finite() {
                failures.push(format!("{input:?} gives {n}"));
            }
        }
    }
    for (name, failures) in [("device", device_failures), ("twin", twin_failures)] {
        let few = failures
            .iter()
            .take(5)
            .cloned()
            .collect::<Vec<_>>()
            .join("\n");
        assert!(
            failures.is_empty(),
            "{name}: {} of {}:\n{few}",
            failures.len(),
            inputs.len()
        );
    }
}
