//! Occlusion by a pair of horizons: `horizon.wgsl` on the device against its twin, and both against numeric integrals.

use std::f64::consts::{FRAC_PI_2, PI};

use bevy::math::{DVec3, Vec3};
use kit::{
    compute::Compute,
    random::Random,
    reference::shader_library::horizon::{SliceNormal, arc, segment, side_occlusion, slice_normal},
    shipped_wgsl,
    wgsl::WgslModule,
};

const MODULE: WgslModule = shipped_wgsl!("shader_library/horizon.wgsl");

const SEGMENT: &str = "
#import bevy_lean_deferred::horizon::segment
fn kernel(bits: array<u32, 1>) -> array<u32, 1> {
    return array(bitcast<u32>(segment(bitcast<f32>(bits[0]))));
}";

const SLICE_NORMAL: &str = "
#import bevy_lean_deferred::horizon::slice_normal
fn kernel(bits: array<u32, 9>) -> array<u32, 3> {
    let normal = bitcast<vec3<f32>>(vec3(bits[0], bits[1], bits[2]));
    let to_viewer = bitcast<vec3<f32>>(vec3(bits[3], bits[4], bits[5]));
    let tangent = bitcast<vec3<f32>>(vec3(bits[6], bits[7], bits[8]));
    let s = slice_normal(vec2(dot(normal, to_viewer), dot(normal, tangent)));
    return array(bitcast<u32>(s.length), bitcast<u32>(s.cosine), bitcast<u32>(s.sine));
}";

/// Evaluates `arc` to the horizon, and `side_occlusion` between it and the surface.
const SIDE: &str = "
#import bevy_lean_deferred::horizon::{SliceNormal, arc, side_occlusion}
fn kernel(bits: array<u32, 6>) -> array<u32, 2> {
    let normal = SliceNormal(bitcast<f32>(bits[0]), bitcast<f32>(bits[1]), bitcast<f32>(bits[2]));
    let c = bitcast<f32>(bits[4]);
    let side = bitcast<f32>(bits[5]);
    return array(
        bitcast<u32>(arc(normal, c, side)),
        bitcast<u32>(side_occlusion(normal, bitcast<f32>(bits[3]), c, side)),
    );
}";

/// Floats that arithmetic may produce by mistake.
const HOSTILE: [f32; 12] = [
    0.0,
    -0.0,
    1e-45,
    1e-20,
    0.5,
    1.0,
    -1.0,
    1.0 + f32::EPSILON,
    1e30,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

fn bits<const N: usize>(inputs: &[[f32; N]]) -> Vec<[u32; N]> {
    inputs.iter().map(|input| input.map(f32::to_bits)).collect()
}

/// Largest difference between device and twin, over inputs whose twin is finite.
fn largest_difference<const N: usize>(device: &[[u32; N]], twin: &[[f32; N]]) -> f32 {
    let device = device.as_flattened().iter().copied().map(f32::from_bits);
    device
        .zip(twin.as_flattened())
        .filter(|(_, twin)| twin.is_finite())
        .map(|(device, twin)| (device - twin).abs())
        .fold(0.0, |largest, difference| {
            // `max` would ignore NaN.
            if difference <= largest {
                largest
            } else {
                difference
            }
        })
}

fn unit_vector(random: &mut Random) -> Vec3 {
    loop {
        let v = Vec3::from_array([(); 3].map(|()| random.range(-1.0, 1.0)));
        if (0.01..1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}

/// Cosines, evenly spaced and crowded at both ends, where the square root is steepest.
fn cosines() -> Vec<f32> {
    let even = (0..=1 << 20).map(|i| i as f32 / (1 << 19) as f32 - 1.0);
    let crowded = (0..=24 << 8).map(|i| 1.0 - (-i as f32 / 256.0).exp2());
    even.chain(crowded.flat_map(|x| [x, -x])).collect()
}

#[test]
fn segment_keeps_its_bound_and_device_and_twin_agree() {
    let cosines = cosines();
    let exact = |c: f64| c.acos() - c * (1.0 - c * c).sqrt();
    let error = |c: f32| (f64::from(segment(c)) - exact(f64::from(c))).abs();
    let largest = cosines.iter().map(|x| error(*x)).fold(0.0, f64::max);
    println!("segment: largest error {largest:.2e} of {}", cosines.len());
    assert!(largest <= 6.8e-6);

    let inputs: Vec<[f32; 1]> = cosines.iter().chain(&HOSTILE).map(|x| [*x]).collect();
    let twin: Vec<[f32; 1]> = inputs.iter().map(|[x]| [segment(*x)]).collect();
    let compute = Compute::new();
    let device = compute.kernel(&[MODULE], SEGMENT).run(&bits(&inputs));
    let difference = largest_difference(&device, &twin);
    println!("segment: device and twin differ by at most {difference:.1e}");
    assert!(difference <= 5e-7);
}

#[test]
fn device_and_twin_project_normals_alike() {
    let mut random = Random::new(1);
    let mut inputs: Vec<[Vec3; 3]> = (0..200_000)
        .map(|i| {
            let to_viewer = unit_vector(&mut random);
            let tangent = to_viewer.cross(unit_vector(&mut random)).normalize();
            let across = to_viewer.cross(tangent);
            let normal = match i % 4 {
                0 | 1 => unit_vector(&mut random),
                // Nearly perpendicular to the slice.
                2 => (across + 1e-5 * unit_vector(&mut random)).normalize(),
                _ => across * 10f32.powf(random.range(-30.0, 0.0)),
            };
            [normal, to_viewer, tangent]
        })
        .collect();
    let axes = [Vec3::Z, Vec3::X];
    let hostile = HOSTILE.iter().flat_map(|x| {
        let normals = [Vec3::ZERO, Vec3::splat(*x), Vec3::X * *x, Vec3::Z * *x];
        normals.map(|normal| [normal, axes[0], axes[1]])
    });
    inputs.extend(hostile);

    let words: Vec<[f32; 9]> = inputs
        .iter()
        .map(|[a, b, c]| [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z])
        .collect();
    let compute = Compute::new();
    let device = compute.kernel(&[MODULE], SLICE_NORMAL).run(&bits(&words));
    let mut largest = 0.0f32;
    for (input, device) in inputs.iter().zip(&device) {
        let [length, cosine, sine] = device.map(f32::from_bits);
        let twin = slice_normal(input[0], input[1], input[2]);
        // At a length near the threshold, the two may fall on either side of it.
        let is_short = (0.9e-6..1.1e-6).contains(&twin.length);
        if !twin.length.is_finite() || twin.length > 1e18 || is_short {
            continue;
        }
        // The dot products cancel down to the remaining length.
        let rounding = 4.0 * f32::EPSILON * input[0].length() / twin.length.max(1e-6);
        let difference = (length - twin.length)
            .abs()
            .max((cosine - twin.cosine).abs().max((sine - twin.sine).abs()));
        assert!(
            difference <= 1e-6 + rounding,
            "{input:?}: {device:?}, {twin:?}"
        );
        largest = largest.max(difference - rounding);
        assert!((cosine.hypot(sine) - 1.0).abs() < 1e-5);
    }
    println!("slice_normal: beyond rounding, device and twin differ by at most {largest:.1e}");
}

/// A normal in a slice, the surface's horizon, a horizon at or above it, and a side, per input.
fn random_sides(count: usize) -> Vec<[f32; 6]> {
    let mut random = Random::new(2);
    (0..count)
        .map(|i| {
            // The last third is at grazing angles.
            let angle = match i % 3 {
                0 | 1 => random.range(-FRAC_PI_2 as f32, FRAC_PI_2 as f32),
                _ => FRAC_PI_2 as f32 - 10f32.powf(random.range(-7.0, -1.0)),
            };
            let side = if random.bits() & 1 == 0 { -1.0 } else { 1.0 };
            let (sine, cosine) = (side * angle).sin_cos();
            // Horizon of the tangent plane of the surface or of a normal map, and a horizon above it.
            let base = if i.is_multiple_of(2) {
                -side * sine
            } else {
                random.range(-1.0, 1.0)
            };
            let c = base + (1.0 - base) * random.unit();
            [random.unit(), cosine, sine, base, c, side]
        })
        .collect()
}

fn twin_side([length, cosine, sine, base, c, side]: [f32; 6]) -> [f32; 2] {
    let normal = SliceNormal {
        length,
        cosine,
        sine,
    };
    [arc(normal, c, side), side_occlusion(normal, base, c, side)]
}

#[test]
fn device_and_twin_hide_alike() {
    let inputs = random_sides(300_000);
    let compute = Compute::new();
    let kernel = compute.kernel(&[MODULE], SIDE);
    let device = kernel.run(&bits(&inputs));
    let twin: Vec<[f32; 2]> = inputs.iter().map(|input| twin_side(*input)).collect();
    let difference = largest_difference(&device, &twin);
    println!("arc and side_occlusion: device and twin differ by at most {difference:.1e}");
    assert!(difference <= 1e-6);

    // For any horizons the result is either valid occlusion or not finite. A slice may exceed its share of the hemisphere: π/2 if the
    // surface is seen edge-on.
    let hostile: Vec<[f32; 6]> = (0..HOSTILE.len().pow(3))
        .flat_map(|i| {
            let [length, base, c] = [1, 12, 144].map(|place| HOSTILE[i / place % 12]);
            let directions = [(1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.6, 0.8)];
            directions.map(|(cosine, sine)| [length, cosine, sine, base, c, 1.0])
        })
        .filter(|[length, ..]| length.is_nan() || (0.0..=1.0 + f32::EPSILON).contains(length))
        .collect();
    let device = kernel.run(&bits(&hostile));
    let mut range = [0.0f32; 2];
    let mut others = 0;
    for (input, [_, device]) in hostile.iter().zip(device) {
        for (whose, x) in [
            ("device", f32::from_bits(device)),
            ("twin", twin_side(*input)[1]),
        ] {
            others += u32::from(!x.is_finite());
            if x.is_finite() {
                assert!(
                    (0.0..=FRAC_PI_2 as f32 + 1e-4).contains(&x),
                    "{whose} of {input:?}: {x}"
                );
                range = [range[0].min(x), range[1].max(x)];
            }
        }
    }
    println!(
        "side_occlusion of {} hostile inputs: {range:?}, {others} not finite",
        hostile.len()
    );
}

/// Cosine-weighted light between two angles to the viewer, by the midpoint rule.
fn integral(normal_angle: f64, from: f64, to: f64) -> f64 {
    const STEPS: u32 = 4096;
    let width = (to - from) / f64::from(STEPS);
    let light = |i: u32| {
        let angle = from + width * (f64::from(i) + 0.5);
        (angle - normal_angle).cos() * angle.sin()
    };
    (0..STEPS).map(light).sum::<f64>() * width
}

#[test]
fn arcs_are_integrals_of_the_cosine() {
    let mut random = Random::new(3);
    let mut largest = [0.0f64; 2];
    for _ in 0..2000 {
        let angle = f64::from(random.range(-FRAC_PI_2 as f32, FRAC_PI_2 as f32));
        let horizon = f64::from(random.unit()) * (angle + FRAC_PI_2).min(PI);
        for side in [1.0, -1.0] {
            let (sine, cosine) = (f64::from(side) * angle).sin_cos();
            let normal = SliceNormal {
                length: 1.0,
                cosine: cosine as f32,
                sine: sine as f32,
            };
            let c = horizon.cos() as f32;
            let found = f64::from(arc(normal, c, side));
            let error = (found - integral(angle, 0.0, horizon)).abs();
            largest[0] = largest[0].max(error);

            let surface = -side * normal.sine;
            let found = f64::from(side_occlusion(normal, surface, c, side));
            let truth = integral(angle, horizon, angle + FRAC_PI_2);
            largest[1] = largest[1].max((found - truth).abs());
        }
    }
    let [of_arc, of_side] = largest;
    println!("arc: largest error {of_arc:.1e}; side_occlusion: {of_side:.1e}");
    assert!(of_arc <= 3.8e-5 && of_side <= 4.5e-5);
}

/// The mean over all slices through a pixel is 1 if everything above the surface is occluded, and 0 if nothing is.
#[test]
fn hemispheres_are_whole() {
    const SLICES: u32 = 256;
    let mut random = Random::new(4);
    let mut largest = 0.0f64;
    for i in 0..500 {
        let to_viewer = Vec3::Z;
        let tilt = if i % 2 == 0 {
            random.range(0.0, 1.57)
        } else {
            FRAC_PI_2 as f32 - 10f32.powf(random.range(-6.0, -1.0))
        };
        let (sin, cos) = tilt.sin_cos();
        let (sin_azimuth, cos_azimuth) = random.range(0.0, core::f32::consts::TAU).sin_cos();
        let normal = Vec3::new(sin * cos_azimuth, sin * sin_azimuth, cos);
        let mean = |c: Option<f32>| {
            let slices = (0..SLICES).map(|slice| {
                let (sin, cos) = (PI * (f64::from(slice) + 0.5) / f64::from(SLICES)).sin_cos();
                let tangent = DVec3::new(cos, sin, 0.0).as_vec3();
                let normal = slice_normal(normal, to_viewer, tangent);
                [1.0, -1.0].map(|side| {
                    let surface = -side * normal.sine;
                    f64::from(side_occlusion(normal, surface, c.unwrap_or(surface), side))
                })
            });
            slices.map(|[a, b]| a + b).sum::<f64>() / f64::from(SLICES)
        };
        assert_eq!(mean(None), 0.0, "of {normal}");
        largest = largest.max((mean(Some(1.0)) - 1.0).abs());
    }
    println!("closed hemispheres: at most {largest:.1e} from 1");
    assert!(largest <= 1.5e-5);
}
