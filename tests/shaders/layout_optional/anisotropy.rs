//! The angle of the tangent of anisotropy.

use core::f64::consts::PI;

use bevy::math::{DVec3, IVec3, Vec3};

use super::forms::{Field, Values};
use kit::{
    random::Random,
    reference::{shader_library::layout, shading_models::anisotropy},
};

fn direction(x: &[f32]) -> DVec3 {
    Vec3::new(x[0], x[1], x[2]).as_dvec3()
}

/// Components of the tangent along the two tangents of the frame.
fn projected(values: &Values) -> [f64; 2] {
    let normal = direction(&values[4..]);
    // The frame of the twin itself: a quarter turn apart, at codes 0 and 512.
    let frame = [0, 512].map(|code| {
        let tangent = anisotropy::unpack_anisotropy_tangent(code << 7, normal.as_vec3());
        tangent.as_dvec3()
    });
    frame.map(|axis| axis.dot(direction(&values[1..])))
}

/// The bits of the angle.
pub const ANGLE: Field = Field {
    shift: 7,
    bits: 10,
    value: 1,
    place: |_, values| {
        let [x, y] = projected(values);
        y.atan2(x) / PI * 1024.0
    },
    tie: |values| {
        let [x, y] = projected(values);
        let size = x.abs() + y.abs();
        let length = direction(&values[1..]).abs().element_sum();
        // Either side may or may not get a direction if sums overflow or fall below the least length.
        if !length.is_finite() || length > 7e37 || (size - 1e-30).abs() < 1e-35 {
            return f64::INFINITY;
        }
        // The component along the normal cancels, and its rounding remains.
        let cancelled = length / size;
        if cancelled > 1e4 {
            f64::INFINITY
        } else {
            1e-2 + 1e-3 * cancelled
        }
    },
    wraps: true,
};

/// A random direction perpendicular to `normal`.
fn tangent_of(normal: DVec3, random: &mut Random) -> DVec3 {
    loop {
        let mut part = || f64::from(random.range(-1.0, 1.0));
        let across = DVec3::new(part(), part(), part()).cross(normal);
        if across.length() > 0.1 {
            return across.normalize();
        }
    }
}

/// Angle in degrees between two undirected lines.
fn angle_of_lines(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b).abs()).to_degrees()
}

#[test]
fn tangents_are_as_exact_as_documented() {
    const COUNT: u32 = 1_000_000;
    let mut random = Random::new(3);
    let normal = |random: &mut Random, kind: u32| -> DVec3 {
        let mut part = || f64::from(random.range(-1.0, 1.0));
        let (x, y, z) = (part(), part(), part());
        match kind {
            0 => DVec3::new(x, y, z * 1e-4),
            1 => DVec3::new(x * 1e-2, y * 1e-2, -1.0),
            _ => DVec3::new(x, y, z),
        }
        .normalize()
    };
    for (kind, name) in [(0, "z near 0"), (1, "z near -1"), (2, "all")] {
        let (mut sum, mut largest, mut about_normal) = (0.0, 0.0f64, 0.0f64);
        for _ in 0..COUNT {
            let normal = normal(&mut random, kind);
            let tangent = tangent_of(normal, &mut random);
            let stored = layout::unpack_normal(layout::pack_normal(normal.as_vec3(), 0.0));
            let arguments = anisotropy::pack_anisotropy(1.0, tangent.as_vec3(), stored);
            let decoded = anisotropy::unpack_anisotropy_tangent(arguments, stored).as_dvec3();
            assert!(
                (decoded.length() - 1.0).abs() < 1e-6
                    && decoded.dot(stored.as_dvec3()).abs() < 1e-6
            );

            let error = angle_of_lines(decoded, tangent);
            sum += error;
            largest = largest.max(error);
            let across = tangent.reject_from(stored.as_dvec3());
            about_normal = about_normal.max(angle_of_lines(decoded, across));
        }
        let mean = sum / f64::from(COUNT);
        println!(
            "anisotropy, {name}: mean {mean:.4}°, largest {largest:.4}°, about the stored normal {about_normal:.4}°"
        );
        assert!((mean - 0.048).abs() < 0.004 && largest < 0.0975, "{name}");
        // Half a step of 1024 over half a turn.
        assert!(about_normal < 90.0 / 1024.0 + 1e-4, "{name}");
    }
}

#[test]
fn tangents_do_not_hang_on_the_last_bits_of_common_normals() {
    // Passes may contract the decoding of a normal differently. Walls, axes, edges and corners of a box.
    let mut random = Random::new(4);
    let walls = (0..10_000).map(|_| {
        let angle = random.range(-3.2, 3.2);
        Vec3::new(angle.cos(), angle.sin(), 0.0)
    });
    let box_directions = (0..27).map(|i| IVec3::new(i % 3, i / 3 % 3, i / 9).as_vec3() - 1.0);
    let normals: Vec<Vec3> = walls
        .chain(box_directions.filter(|n| *n != Vec3::ZERO))
        .collect();
    for normal in normals {
        let normal = layout::unpack_normal(layout::pack_normal(normal, 0.0));
        for moved in [-1e-6, 1e-6].map(|z| (normal + z * Vec3::Z).normalize()) {
            for angle in [0, 200, 700] {
                let decoded = |n| anisotropy::unpack_anisotropy_tangent(angle << 7, n).as_dvec3();
                let turned = angle_of_lines(decoded(normal), decoded(moved));
                assert!(turned < 0.001, "{normal} turns {turned}°");
            }
        }
    }
}
