//! The sum over all pixels, by both paths, against double precision.

use std::process::Command;

use bevy::math::{UVec2, Vec3};
use bevy_lean_deferred::effects::auto_exposure::{ExposureState, LeanAutoExposure};

use crate::{
    METERINGS, instant, paths,
    pictures::{EASY, HOSTILE, picture},
};
use kit::{
    exposure_gpu::{ExposureGpu, Meter},
    exposure_reference as reference,
    skipped::on_swiftshader,
};

const SIZES: [UVec2; 10] = [
    UVec2::new(1, 1),
    UVec2::new(3, 5),
    UVec2::new(7, 1),
    UVec2::new(1, 129),
    UVec2::new(64, 128),
    UVec2::new(65, 127),
    UVec2::new(131, 257),
    UVec2::new(317, 211),
    UVec2::new(1009, 97),
    UVec2::new(1280, 720),
];

/// Cameras that see all of `picture`, by each path.
fn by_paths<'a>(
    gpu: &'a ExposureGpu,
    settings: &LeanAutoExposure,
    picture: &wgpu::Texture,
) -> Vec<Meter<'a>> {
    let whole = (UVec2::ZERO, UVec2::new(picture.width(), picture.height()));
    paths(gpu)
        .into_iter()
        .map(|path| Meter::new(gpu, settings, path, picture, whole, None))
        .collect()
}

/// Each pixel counts once at any size, by either path and either mean, for any content.
#[test]
fn every_pixel_counts_once() {
    let gpu = ExposureGpu::new();
    println!(
        "{}, subgroups of {} to {}",
        gpu.adapter.name, gpu.adapter.subgroup_min_size, gpu.adapter.subgroup_max_size
    );
    let most = on_swiftshader(1e-5, 3e-6, "logarithms that cancel");
    // Pipelines are shared by pictures of one size: compiling them takes longer than running them.
    let meters = SIZES.map(|size| {
        let texture = gpu.picture(size, &picture(size, EASY[0].1));
        METERINGS.map(|metering| {
            let settings = LeanAutoExposure {
                metering,
                ..instant()
            };
            (by_paths(&gpu, &settings, &texture), settings)
        })
    });
    for (name, texel) in EASY.into_iter().chain(HOSTILE) {
        let (mut worst, mut apart) = (0.0f64, 0.0f64);
        for (size, meters) in SIZES.into_iter().zip(&meters) {
            let texels = picture(size, texel);
            let texture = gpu.picture(size, &texels);
            for (meters, settings) in meters {
                let whole = (UVec2::ZERO, size);
                let expected = reference::metered(settings, &texels, size, whole, None);
                let states: Vec<ExposureState> = meters
                    .iter()
                    .map(|meter| meter.another(&texture, None).frame(0.1, 0))
                    .collect();
                for state in &states {
                    assert!(state.exposure.is_finite() && state.target_exposure.is_finite());
                    let Some(expected) = expected else {
                        assert_eq!((state.luminance, state.exposure), (0.0, 0.0));
                        continue;
                    };
                    // Relative error; black must be black.
                    let error = (f64::from(state.luminance) - expected).abs() / expected.max(1e-30);
                    worst = worst.max(error);
                    let other = f64::from(states[0].luminance);
                    apart =
                        apart.max((f64::from(state.luminance) - other).abs() / expected.max(1e-30));
                }
            }
        }
        println!("{name}: off by up to {worst:.1e}, paths {apart:.1e} apart");
        assert!(worst <= 1e-5);
        assert!(apart <= most);
    }
}

/// In a picture of half a gigabyte, sums and weights stay exact.
#[test]
#[ignore = "nightly: a picture of half a gigabyte"]
fn large_pictures_are_as_exact() {
    let gpu = ExposureGpu::new();
    let size = UVec2::splat(8192);
    if gpu.device.limits().max_texture_dimension_2d < size.x {
        println!("skipped: a picture of {size}: the device has no such textures");
        return;
    }
    // Repeats after 8 rows, so that the mean is that of 8 rows.
    let band_size = UVec2::new(size.x, 8);
    for (name, texel) in [EASY[1], EASY[2], HOSTILE[3]] {
        let band = picture(band_size, texel);
        let texture = gpu.picture(size, &band.repeat((size.y / band_size.y) as usize));
        for metering in METERINGS {
            let settings = LeanAutoExposure {
                metering,
                ..instant()
            };
            let whole = (UVec2::ZERO, band_size);
            let expected = reference::metered(&settings, &band, band_size, whole, None);
            let expected = expected.expect("there are numbers among them");
            for meter in by_paths(&gpu, &settings, &texture) {
                let state = meter.frame(0.1, 0);
                let error = (f64::from(state.luminance) / expected - 1.0).abs();
                println!("{name}, {metering:?}: off by {error:.1e}");
                assert!(error <= 1e-5);
            }
        }
    }
}

/// With nothing to meter, the target stays.
#[test]
fn a_view_of_no_numbers_keeps_its_target() {
    let gpu = ExposureGpu::new();
    let size = UVec2::new(37, 21);
    let picture_of = |value: f32| vec![Vec3::splat(value); size.element_product() as usize];
    let settings = LeanAutoExposure {
        range: -20.0..=20.0,
        ..instant()
    };
    for path in paths(&gpu) {
        let texture = gpu.picture(size, &picture_of(0.045));
        let meter = Meter::new(&gpu, &settings, path, &texture, (UVec2::ZERO, size), None);
        let before = meter.frame(0.1, 0);
        assert!((before.exposure - 2.0).abs() < 1e-3);
        gpu.overwrite(&texture, &picture_of(f32::NAN));
        let after = meter.frame(0.1, 0);
        assert_eq!(
            (before.luminance, before.exposure),
            (after.luminance, after.exposure)
        );
    }
}

/// On software renderers with subgroups of other sizes, if these are requested, all of the above holds too.
#[test]
#[ignore = "nightly: other drivers in effect: tests of this binary, three times more"]
fn subgroups_may_have_any_size() {
    const WIDTH: &str = "LP_NATIVE_VECTOR_WIDTH";
    let gpu = ExposureGpu::new();
    if !gpu.adapter.name.contains("llvmpipe") || std::env::var_os(WIDTH).is_some() {
        println!("subgroups of {} alone", gpu.adapter.subgroup_min_size);
        return;
    }
    let program = std::env::current_exe().expect("a test is a program");
    for (width, size) in [("128", 4), ("256", 8), ("512", 16)] {
        let output = Command::new(&program)
            .args([
                "every_pixel_counts_once",
                "patterns_weight",
                "trimming",
                "--nocapture",
            ])
            .env(WIDTH, width)
            .output()
            .expect("it runs again");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{text}");
        assert!(
            text.contains(&format!("subgroups of {size} to {size}")),
            "{text}"
        );
        assert!(text.contains("3 passed"), "{text}");
    }
}
