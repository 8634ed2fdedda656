//! Loss of storing a surface in the G-buffer, against that of other layouts of the same bits.

use bevy::math::{DVec2, DVec3, Vec2Swizzles as _, Vec3};
use kit::{
    random::Random,
    reference::shader_library::layout::{self, NORMAL_STEPS},
};

/// A transfer curve for albedo.
struct Curve {
    name: &'static str,
    /// From linear to stored.
    encode: fn(f64) -> f64,
    decode: fn(f64) -> f64,
}

const SRGB: Curve = Curve {
    name: "sRGB",
    encode: |x| {
        if x <= 0.003_130_8 {
            12.92 * x
        } else {
            1.055 * x.powf(1.0 / 2.4) - 0.055
        }
    },
    decode: |x| {
        if x <= 0.04045 {
            x / 12.92
        } else {
            ((x + 0.055) / 1.055).powf(2.4)
        }
    },
};

/// The curves that were considered, with their documented errors (RMS and largest, in 1/255 of sRGB) in 7 bits.
const CURVES: [(Curve, [f64; 2]); 4] = [
    (SRGB, [0.58, 1.00]),
    (
        Curve {
            name: "gamma 2.0",
            encode: f64::sqrt,
            decode: |x| x * x,
        },
        [0.60, 1.43],
    ),
    (
        Curve {
            name: "gamma 2.2",
            encode: |x| x.powf(1.0 / 2.2),
            decode: |x| x.powf(2.2),
        },
        [0.60, 1.21],
    ),
    (
        Curve {
            name: "linear",
            encode: |x| x,
            decode: |x| x,
        },
        [2.25, 12.75],
    ),
];

/// Root mean square and largest of `values`.
fn rms_and_largest(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (mut count, mut squares, mut largest) = (0.0, 0.0, 0.0f64);
    for value in values {
        count += 1.0;
        squares += value * value;
        largest = largest.max(value.abs());
    }
    [f64::sqrt(squares / count), largest]
}

/// Values from 0 to 1 in sRGB.
fn srgb_values() -> impl Iterator<Item = f64> {
    const COUNT: u32 = 1 << 20;
    (0..=COUNT).map(|i| f64::from(i) / f64::from(COUNT))
}

/// Checks a measured figure against the one that `layout.rs` documents.
fn assert_documented(what: &str, measured: f64, documented: f64, tolerance: f64) {
    assert!(
        (measured - documented).abs() <= tolerance,
        "{what}: measured {measured}, documented {documented}"
    );
}

#[test]
fn albedo_errors_are_as_documented() {
    for (curve, documented) in CURVES {
        let measured = rms_and_largest(srgb_values().map(|srgb| {
            let stored = ((curve.encode)((SRGB.decode)(srgb)) * 127.0).round() / 127.0;
            255.0 * ((SRGB.encode)((curve.decode)(stored)) - srgb)
        }));
        let [rms, largest] = measured;
        println!(
            "albedo, 7 bits, {:9}: RMS {rms:.3}, largest {largest:.3}",
            curve.name
        );
        assert_documented(curve.name, rms, documented[0], 0.006);
        assert_documented(curve.name, largest, documented[1], 0.006);
    }
}

/// RMS and largest error of `values` in 1/255 of sRGB, as packed.
fn packed_albedo_errors(values: impl Iterator<Item = f64>) -> [f64; 2] {
    rms_and_largest(values.map(|srgb| {
        let linear = (SRGB.decode)(srgb);
        let word = layout::pack_surface(Vec3::splat(linear as f32), 0.0, 0.0, false);
        let stored = f64::from(layout::unpack_albedo(word).x);
        255.0 * ((SRGB.encode)(stored) - srgb)
    }))
}

/// Errors of grey: the exponent of other colours follows their brightest channel.
#[test]
fn packed_albedo_is_as_exact_as_documented() {
    let third = f64::from(layout::ALBEDO_LIMIT);
    let twelfth = 0.25 * third;
    let ranges = [
        ("all", 0.0, 1.0, [0.395, 0.966]),
        ("above 1/3", third, 1.0, [0.532, 0.966]),
        ("1/12 to 1/3", twelfth, third, [0.341, 0.626]),
        ("to 1/12", 0.0, twelfth, [0.199, 0.414]),
    ];
    for (name, from, to, documented) in ranges {
        let [from, to] = [from, to].map(SRGB.encode);
        let values = srgb_values().filter(|srgb| (from..to).contains(srgb));
        let [rms, largest] = packed_albedo_errors(values);
        println!("albedo as packed, {name:12}: RMS {rms:.3}, largest {largest:.3}");
        assert_documented(name, rms, documented[0], 0.006);
        assert_documented(name, largest, documented[1], 0.006);
    }
}

/// Angle between `stored` and the unit vector `exact`, in degrees; also accurate for tiny ones.
pub fn angle(stored: Vec3, exact: DVec3) -> f64 {
    let stored = stored.as_dvec3();
    stored
        .cross(exact)
        .length()
        .atan2(stored.dot(exact))
        .to_degrees()
}

fn octahedral_from_unit(n: DVec3) -> DVec2 {
    let p = n.truncate() / n.abs().element_sum();
    if n.z >= 0.0 {
        p
    } else {
        (1.0 - p.yx().abs()) * DVec2::new(1f64.copysign(p.x), 1f64.copysign(p.y))
    }
}

/// Inverse of [`octahedral_from_unit`].
pub fn direction_from_octahedral(p: DVec2) -> DVec3 {
    let z = 1.0 - p.x.abs() - p.y.abs();
    let p = if z >= 0.0 {
        p
    } else {
        (1.0 - p.yx().abs()) * DVec2::new(1f64.copysign(p.x), 1f64.copysign(p.y))
    };
    p.extend(z).normalize()
}

/// `n` as stored by rounding each axis to the same codes separately.
fn naively_stored(n: DVec3) -> DVec3 {
    let steps = f64::from(NORMAL_STEPS);
    let codes = ((octahedral_from_unit(n) * 0.5 + 0.5) * steps).round();
    direction_from_octahedral(codes * (2.0 / steps) - 1.0)
}

/// Points spread evenly over the unit sphere, on a Fibonacci spiral.
fn sphere(count: u32) -> impl Iterator<Item = DVec3> {
    let golden_angle = core::f64::consts::PI * (3.0 - f64::sqrt(5.0));
    (0..count).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (sin, cos) = (golden_angle * f64::from(i)).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cos, radius * sin, z)
    })
}

/// Mean and largest angle between points on the sphere and their directions as stored.
fn normal_errors(store: impl Fn(DVec3) -> Vec3) -> [f64; 2] {
    const COUNT: u32 = 4_000_000;
    let (sum, largest) = sphere(COUNT).fold((0.0, 0.0f64), |(sum, largest), n| {
        let error = angle(store(n), n);
        (sum + error, largest.max(error))
    });
    [sum / f64::from(COUNT), largest]
}

#[test]
fn normal_errors_are_as_documented() {
    let [mean, largest] =
        normal_errors(|n| layout::unpack_normal(layout::pack_normal(n.as_vec3(), 0.0)));
    let [naive_mean, naive_largest] = normal_errors(|n| naively_stored(n).as_vec3());
    println!("normal: mean {mean:.5}°, largest {largest:.5}°");
    println!("normal, each axis on its own: mean {naive_mean:.5}°, largest {naive_largest:.5}°");
    assert!(mean <= 0.0198 && largest <= 0.0400);
    assert_documented("mean error", mean, 0.0195, 6e-5);
    assert_documented("mean error of naive rounding", naive_mean, 0.0209, 6e-5);
    // The worst spots are tiny: this many points come this close to them.
    assert_documented("largest error", largest, 0.0395, 3e-4);
    assert_documented(
        "largest error of naive rounding",
        naive_largest,
        0.0592,
        6e-4,
    );
}

/// On the diagonals of the octants three of the four codes around a normal are equally near: errors are no larger there.
#[test]
fn normals_of_equal_parts_are_as_near_as_others() {
    let mut random = Random::new(5);
    for i in 0..10_000 {
        let scale = random.range(-30.0, 30.0).exp2();
        let sign = |bit: u32| if i >> bit & 1 == 0 { scale } else { -scale };
        // Also where rounding makes one of them the nearest.
        let part = |bit: u32| sign(bit) * (1.0 + (i >> (3 + bit) & 1) as f32 * f32::EPSILON);
        let normal = Vec3::new(part(0), part(1), part(2));
        let stored = layout::unpack_normal(layout::pack_normal(normal, 0.0));
        let error = angle(stored, normal.as_dvec3().normalize());
        assert!(error <= 0.0400, "{normal}: {error}°");
    }
}

#[test]
fn axes_are_exact() {
    for axis in [
        Vec3::X,
        Vec3::NEG_X,
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::Z,
        Vec3::NEG_Z,
    ] {
        let stored = layout::unpack_normal(layout::pack_normal(axis, 0.0));
        assert_eq!(stored, axis);
    }
}
