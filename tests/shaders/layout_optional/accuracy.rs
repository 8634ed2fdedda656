//! Loss of storing emitted light, unlit colours and the arguments of shading models.

use bevy::{
    color::{ColorToComponents, LinearRgba, Srgba},
    math::Vec3,
};
use kit::{
    random::Random,
    reference::{
        shader_library::layout::{light, specialization as special},
        shading_models::{anisotropy, clearcoat, diffuse_transmission, rim, subsurface, unlit},
    },
};

/// `low` to `high`, evenly on a logarithmic scale.
fn logarithmic(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..=count).map(move |i| low * (high / low).powf(f64::from(i) / f64::from(count)))
}

/// The largest error of `store` relative to the values.
fn relative_error(values: impl Iterator<Item = f64>, store: impl Fn(f32) -> f32) -> f64 {
    values
        .map(|x| (f64::from(store(x as f32)) / f64::from(x as f32) - 1.0).abs())
        .fold(0.0, f64::max)
}

/// Largest error of `store` over 0 to `high`.
fn absolute_error(high: f32, store: impl Fn(f32) -> f32) -> f32 {
    const COUNT: u32 = 1 << 18;
    (0..=COUNT)
        .map(|i| {
            let x = high * i as f32 / COUNT as f32;
            (store(x) - x).abs()
        })
        .fold(0.0, f32::max)
}

/// A colour whose brightest channel, a random one, is `brightest`; and the index of that channel.
fn color_of(brightest: f64, random: &mut Random) -> (Vec3, usize) {
    let brightest = brightest as f32;
    let channel = random.below(3);
    let mut color = Vec3::new(random.unit(), random.unit(), random.unit()) * brightest;
    color[channel] = brightest;
    (color, channel)
}

#[test]
fn light_is_as_exact_as_documented() {
    let store = |color| light::unpack_light(light::pack_light(color));
    let mut random = Random::new(6);
    let least_normal = 2f64.powi(-16);
    for decade in -6..5 {
        let (low, high) = (10f64.powi(decade), 10f64.powi(decade + 1).min(65504.0));
        let (mut relative, mut below, mut dim) = (0.0f64, 0.0f64, 0.0f64);
        for brightest in logarithmic(low, high, 200_000) {
            let (color, channel) = color_of(brightest, &mut random);
            let error = (store(color) - color).abs().as_dvec3();
            let brightest = f64::from(color[channel]);
            if brightest >= least_normal {
                relative = relative.max(error[channel] / brightest);
                if brightest <= f64::from(light::LARGEST_LIGHT) {
                    dim = dim.max(error.max_element() / brightest);
                }
            } else {
                below = below.max(error.max_element());
            }
        }
        println!(
            "light, {low:.0e} to {high:.1e}: brightest channel 1/{:.1}, dim ones 1/{:.1} of it; below 1.5e-5 {below:.2e}",
            1.0 / relative,
            1.0 / dim
        );
        assert!(relative <= 1.0 / 512.9 && dim <= 1.0 / 511.4 && below <= 2.981e-8);
    }
}

fn encoded(color: Vec3) -> Vec3 {
    Srgba::from(LinearRgba::from_vec3(color)).to_vec3() * 255.0
}

#[test]
fn unlit_colors_are_as_exact_as_documented() {
    let store = |color| unlit::unpack_unlit(unlit::pack_unlit(color, 0));
    let mut random = Random::new(7);
    let (mut squares, mut largest) = (0.0f64, 0.0f64);
    const COUNT: u32 = 1_000_000;
    for _ in 0..COUNT {
        let color = Srgba::rgb(random.unit(), random.unit(), random.unit());
        let color = LinearRgba::from(color).to_vec3();
        let error = (encoded(store(color)) - encoded(color)).as_dvec3();
        squares += error.length_squared() / 3.0;
        largest = largest.max(error.abs().max_element());
    }
    let rms = (squares / f64::from(COUNT)).sqrt();
    println!("unlit, 0 to 1: RMS {rms:.3}, largest {largest:.3} in 1/255 of sRGB");
    assert!((rms - 0.30).abs() < 0.01 && largest < 1.0);

    // Greys of 8 bits of sRGB.
    let changed = (0..=255u8)
        .filter(|&code| {
            let color = Vec3::splat(LinearRgba::from(Srgba::rgb_u8(code, code, code)).red);
            encoded(store(color)).x.round() != f32::from(code)
        })
        .count();
    println!("unlit: {changed} of 256 greys of 8 bits of sRGB change");

    let (mut relative, mut dim) = (0.0f64, 0.0f64);
    for brightest in logarithmic(1.0, 32768.0, 1_000_000) {
        let (color, channel) = color_of(brightest, &mut random);
        let error = (store(color) - color).abs().as_dvec3();
        let brightest = f64::from(color[channel]);
        relative = relative.max(error[channel] / brightest);
        dim = dim.max(error.max_element() / brightest);
    }
    println!("unlit, 1 to 32768: brightest channel {relative:.5}, dim ones {dim:.5} of it");
    assert!(relative < 0.0056 && dim < 0.0056);
}

#[test]
fn arguments_are_as_exact_as_their_bits_allow() {
    let reflectance = absolute_error(2.0, |x| {
        special::unpack_reflectance(special::pack_specialization(x, 0, 0))
    });
    println!("reflectance: {reflectance:.5}");
    assert!(reflectance <= 0.5001 / 126.0);

    for (name, bits, store) in [
        (
            "clearcoat strength",
            8,
            (|x| clearcoat::unpack_clearcoat_strength(clearcoat::pack_clearcoat(x, 0.3)))
                as fn(f32) -> f32,
        ),
        ("clearcoat roughness", 8, |x| {
            clearcoat::unpack_clearcoat_roughness(clearcoat::pack_clearcoat(0.7, x))
        }),
        ("anisotropy strength", 7, |x| {
            let arguments = anisotropy::pack_anisotropy(x, Vec3::X, Vec3::Z);
            anisotropy::unpack_anisotropy_strength(arguments)
        }),
        ("diffuse transmission", 7, |x| {
            diffuse_transmission::unpack_transmission(
                diffuse_transmission::pack_diffuse_transmission(x, 1.0, true),
            )
        }),
    ] {
        let error = absolute_error(1.0, store);
        println!("{name}: {error:.5}");
        assert!(error <= 0.5001 / ((1 << bits) - 1) as f32, "{name}");
    }

    let thickness = relative_error(logarithmic(1e-6, 3700.0, 1_000_000), |x| {
        diffuse_transmission::unpack_thickness(diffuse_transmission::pack_diffuse_transmission(
            0.0, x, false,
        ))
    });
    println!("thickness, 1 µm to 3.7 km: {thickness:.4} of it");
    assert!(thickness < 0.0219 + 1e-4);
    let path = relative_error(logarithmic(1e-4, 1.0, 1_000_000), |x| {
        subsurface::unpack_subsurface_path(subsurface::pack_subsurface(Vec3::ONE, x, false))
    });
    println!("mean free path, 0.1 mm to 1 m: {path:.4} of it");
    assert!(path < 0.0759 + 2e-4);
    let rim = absolute_error(15.0, |x| {
        rim::unpack_rim_exponent(rim::pack_rim(Vec3::ONE, x + 1.0)) - 1.0
    });
    println!("exponent of rim light: {rim:.3}");
    assert!(rim < 0.49);
}
