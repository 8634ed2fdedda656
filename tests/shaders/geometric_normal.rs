//! Geometric normals from depth: the shipped WGSL on the device against its Rust twin, and their accuracy on surfaces with known normals.

mod accuracy;
mod scenes;

use bevy::math::{DMat4, DVec2, DVec3, IVec2, Mat4, Vec2, Vec3};
use bevy_lean_deferred::shader_library::reconstruction::position::{ProjectionKind, projection_of};
use kit::{
    compute::Compute,
    random::Random,
    reference::shader_library::reconstruction::normal::{
        flatter_slope, normal_from_positions, normal_from_slope, straighter_side,
    },
    shipped_wgsl,
    wgsl::WgslModule,
};
use scenes::{HEIGHT, Lens, WIDTH};

const MODULE: WgslModule = shipped_wgsl!("shader_library/reconstruction/normal.wgsl");

const SIDES: &str = "
#import bevy_lean_deferred::reconstruction::normal::{flatter_slope, straighter_side}
fn kernel(bits: array<u32, 5>) -> array<u32, 2> {
    let center = bitcast<f32>(bits[0]);
    let near_a = bitcast<f32>(bits[1]);
    let far_a = bitcast<f32>(bits[2]);
    let near_b = bitcast<f32>(bits[3]);
    let far_b = bitcast<f32>(bits[4]);
    return array(
        bitcast<u32>(straighter_side(center, near_a, far_a, near_b, far_b)),
        bitcast<u32>(flatter_slope(near_a, center, near_b)),
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

const NORMALS_FROM_SLOPES: &str = "
#import bevy_lean_deferred::reconstruction::normal::normal_from_slope
fn kernel(bits: array<u32, 21>) -> array<u32, 3> {
    var b: array<f32, 21>;
    for (var i = 0; i < 21; i++) {
        b[i] = bitcast<f32>(bits[i]);
    }
    let view_from = mat4x4(
        vec4(b[0], b[1], b[2], b[3]), vec4(b[4], b[5], b[6], b[7]),
        vec4(b[8], b[9], b[10], b[11]), vec4(b[12], b[13], b[14], b[15]),
    );
    let n = bitcast<vec3<u32>>(normal_from_slope(
        view_from, vec2(b[16], b[17]), b[18], vec2(b[19], b[20]),
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
        let twin = straighter_side(center, near_a, far_a, near_b, far_b);
        let [side, slope] = device.map(f32::from_bits);
        assert_eq!(side, twin, "of {input:?}");
        let expected = flatter_slope(near_a, center, near_b);
        // A device may flush the smallest numbers to 0.
        let is_same = (slope - expected).abs() < 1e-37 || slope == expected;
        let is_nan = slope.is_nan() && expected.is_nan();
        assert!(is_same || is_nan, "of {input:?}: {slope}, {expected}");
    }
}

/// Error of `normal_from_positions`, in radians, that is due to f32 positions alone: tangents are differences of positions, and their
/// product is small where they are nearly parallel.
fn rounding_of_normal([cx, cy, cz, hx, hy, hz, _, vx, vy, vz, _]: [f32; 11]) -> f64 {
    let center = DVec3::new(cx.into(), cy.into(), cz.into());
    let h = DVec3::new(hx.into(), hy.into(), hz.into()) - center;
    let v = DVec3::new(vx.into(), vy.into(), vz.into()) - center;
    4.0 * f64::from(f32::EPSILON) * h.length() * v.length() / h.cross(v).length()
}

/// Triples of positions one pixel apart, up to the distance of a silhouette's background; some are collinear.
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

/// Positions of three neighbouring pixels with unrelated depths.
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

/// Planes seen through a lens: a position and the slopes of depth there, with the true normal, which faces the viewer.
fn random_planes(clip_from_view: DMat4, count: usize) -> Vec<([f32; 5], DVec3)> {
    let view_from_clip = clip_from_view.inverse();
    let scale = DVec2::new(view_from_clip.x_axis.x, view_from_clip.y_axis.y);
    let mut random = Random::new(7);
    let mut planes = Vec::new();
    while planes.len() < count {
        let mut next = |low, high| f64::from(random.range(low, high));
        let ndc = DVec2::new(next(-1.0, 1.0), next(-1.0, 1.0));
        let distance = 10f64.powf(next(-0.9, 3.0));
        let depth = clip_from_view
            .project_point3(DVec3::new(0.0, 0.0, -distance))
            .z;
        let center = view_from_clip.project_point3(ndc.extend(depth));
        let normal = DVec3::new(next(-1.0, 1.0), next(-1.0, 1.0), next(-1.0, 1.0)).normalize();
        let to_viewer = view_from_clip.project_point3(ndc.extend(1.0)) - center;
        let cosine = normal.dot(to_viewer.normalize());
        if cosine.abs() < 0.02 {
            continue;
        }
        let normal = normal * cosine.signum();
        // Depth of the plane a little further along each axis.
        let depth_at = |ndc: DVec2| {
            let a = view_from_clip.project_point3(ndc.extend(depth));
            let b = view_from_clip.project_point3(ndc.extend(0.5 * depth));
            let along = (b - a) / normal.dot(b - a);
            clip_from_view
                .project_point3(a + along * normal.dot(center - a))
                .z
        };
        let step = 1e-4;
        let slope = DVec2::new(
            depth_at(ndc + DVec2::X * step) - depth,
            depth_at(ndc + DVec2::Y * step) - depth,
        ) / (step * scale);
        let ray = ndc * scale + view_from_clip.w_axis.truncate().truncate();
        let input = [ray.x, ray.y, depth, slope.x, slope.y].map(|x| x as f32);
        planes.push((input, normal));
    }
    planes
}

#[test]
fn slopes_of_depth_give_the_normals_of_planes() {
    let mut off_center = DMat4::perspective_infinite_reverse_rh(1.0, 1.6, 0.1);
    off_center.z_axis.x = 0.2;
    off_center.z_axis.y = -0.1;
    let lenses = [
        (off_center, Some("PROJECTION_PERSPECTIVE")),
        (
            DMat4::perspective_rh(0.7, 1.0, 1e4, 0.1),
            Some("PROJECTION_PERSPECTIVE"),
        ),
        (DMat4::orthographic_rh(-4.0, 5.0, -3.0, 3.0, 2e3, 0.1), None),
    ];
    let compute = Compute::new();
    for (clip_from_view, definition) in lenses {
        let kind = projection_of(clip_from_view.as_mat4());
        assert_eq!(kind == ProjectionKind::Perspective, definition.is_some());
        let definitions: Vec<_> = definition.map(|name| (name, 1)).into_iter().collect();
        let kernel = compute.kernel_with::<21, 3>(&[MODULE], NORMALS_FROM_SLOPES, &definitions);
        let view_from_clip = clip_from_view.inverse().as_mat4();
        let planes = random_planes(clip_from_view, 100_000);
        let inputs: Vec<[u32; 21]> = planes
            .iter()
            .map(|(input, _)| {
                let mut words = [0; 21];
                for (word, x) in words
                    .iter_mut()
                    .zip(view_from_clip.to_cols_array().iter().chain(input))
                {
                    *word = x.to_bits();
                }
                words
            })
            .collect();
        let mut worst = 0f64;
        for ((input, truth), device) in planes.iter().zip(kernel.run(&inputs)) {
            let [x, y, depth, slope_x, slope_y] = *input;
            let (ray, slope) = (Vec2::new(x, y), Vec2::new(slope_x, slope_y));
            let twin = normal_from_slope(view_from_clip, kind, ray, depth, slope);
            let device = Vec3::from_array(device.map(f32::from_bits));
            for n in [device, twin] {
                worst = worst.max(n.as_dvec3().distance(*truth));
            }
        }
        println!("{kind:?}: off by {worst:.1e} at most");
        assert!(worst < 1e-6, "{kind:?}: off by {worst}");
    }
}

#[test]
fn hostile_slopes_give_unit_normals() {
    const HOSTILE: [f32; 7] = [0.0, 1e-30, -1e-7, 0.5, 1e30, f32::INFINITY, f32::NAN];
    let compute = Compute::new();
    let view_from_clip = Mat4::perspective_infinite_reverse_rh(1.0, 1.6, 0.1).inverse();
    for definition in [Some("PROJECTION_PERSPECTIVE"), None] {
        let definitions: Vec<_> = definition.map(|name| (name, 1)).into_iter().collect();
        let kernel = compute.kernel_with::<21, 3>(&[MODULE], NORMALS_FROM_SLOPES, &definitions);
        let inputs: Vec<[u32; 21]> = (0..343)
            .map(|i| {
                let hostile = [1, 7, 49].map(|place| HOSTILE[i / place % 7]);
                let input = [0.3, -0.4].into_iter().chain(hostile);
                let mut words = [0; 21];
                for (word, x) in words
                    .iter_mut()
                    .zip(view_from_clip.to_cols_array().into_iter().chain(input))
                {
                    *word = x.to_bits();
                }
                words
            })
            .collect();
        for (input, device) in inputs.iter().zip(kernel.run(&inputs)) {
            let n = Vec3::from_array(device.map(f32::from_bits));
            assert!(
                (n.length() - 1.0).abs() < 1e-5,
                "{:?} gives {n}",
                &input[16..]
            );
        }
    }
}
