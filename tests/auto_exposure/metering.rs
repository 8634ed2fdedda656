//! Weights of pixels in metering.

use bevy::{
    asset::Handle,
    math::{UVec2, Vec3},
};
use bevy_lean_deferred::effects::auto_exposure::{
    LeanAutoExposure, LuminanceTrim, MeteringPattern,
};

use crate::{
    METERINGS, instant, paths,
    pictures::{EASY, HOSTILE, picture},
};
use kit::{
    exposure_gpu::{ExposureGpu, Meter},
    exposure_reference::{self as reference, Mask},
    random::Random,
};

/// Largest relative error of luminance over viewports, means and paths.
fn worst_error(gpu: &ExposureGpu, settings: &LeanAutoExposure, mask: Option<&Mask>) -> f64 {
    let mut worst = 0.0f64;
    for (size, viewport) in [
        (UVec2::new(211, 137), (UVec2::ZERO, UVec2::new(211, 137))),
        (
            UVec2::new(211, 137),
            (UVec2::new(31, 17), UVec2::new(97, 101)),
        ),
        (UVec2::new(9, 4), (UVec2::new(8, 3), UVec2::ONE)),
    ] {
        let pictures = [EASY[1], HOSTILE[0], HOSTILE[1]].map(|(_, texel)| {
            let mut texels = picture(size, texel);
            // Pixels outside the viewport must not count.
            for (i, texel) in texels.iter_mut().enumerate() {
                let pixel = UVec2::new(i as u32 % size.x, i as u32 / size.x);
                if pixel.cmplt(viewport.0).any() || pixel.cmpge(viewport.0 + viewport.1).any() {
                    *texel = Vec3::splat(60000.0);
                }
            }
            (gpu.picture(size, &texels), texels)
        });
        let mask_texture = mask.map(|mask| gpu.mask(mask.size, &mask.texels));
        let mask_texture = mask_texture.as_ref();
        for metering in METERINGS {
            let settings = LeanAutoExposure {
                metering,
                ..settings.clone()
            };
            // Pipelines are shared by pictures: compiling them takes longer than running them.
            let [(first, _), ..] = &pictures;
            let meters: Vec<Meter> = paths(gpu)
                .into_iter()
                .map(|path| Meter::new(gpu, &settings, path, first, viewport, mask_texture))
                .collect();
            for (texture, texels) in &pictures {
                let Some(expected) = reference::metered(&settings, texels, size, viewport, mask)
                else {
                    continue;
                };
                for meter in &meters {
                    let state = meter.another(texture, mask_texture).frame(0.1, 0);
                    worst = worst.max((f64::from(state.luminance) / expected - 1.0).abs());
                }
            }
        }
    }
    worst
}

#[test]
fn patterns_weight() {
    let gpu = ExposureGpu::new();
    for (pattern, bound) in [
        (MeteringPattern::Average, 1e-5),
        (MeteringPattern::CenterWeighted, 1e-5),
        (MeteringPattern::Spot { radius: 0.05 }, 1e-5),
        (MeteringPattern::Spot { radius: 0.37 }, 1e-5),
    ] {
        let settings = LeanAutoExposure {
            pattern: pattern.clone(),
            ..instant()
        };
        let worst = worst_error(&gpu, &settings, None);
        println!("{pattern:?}: off by up to {worst:.1e}");
        assert!(worst <= bound);
    }
}

/// Masks of any size weight pixels; the error is that of the device's filter, which has 8 bits.
#[test]
fn masks_weight() {
    let gpu = ExposureGpu::new();
    let settings = LeanAutoExposure {
        pattern: MeteringPattern::Mask(Handle::default()),
        ..instant()
    };
    let mut random = Random::new(5);
    for size in [
        UVec2::ONE,
        UVec2::new(2, 3),
        UVec2::new(64, 64),
        UVec2::new(333, 17),
    ] {
        let texels = (0..size.element_product()).map(|_| (random.bits() >> 24) as u8 | 1);
        let mask = Mask {
            size,
            texels: texels.collect(),
        };
        let worst = worst_error(&gpu, &settings, Some(&mask));
        println!("mask of {size}: off by up to {worst:.1e}");
        assert!(worst <= 2e-3);
    }
}

/// Pixels with a NaN or negative mask weight do not count; others count as usual.
#[test]
fn masks_may_be_hostile() {
    let gpu = ExposureGpu::new();
    let size = UVec2::new(40, 30);
    let texture = gpu.picture(size, &vec![Vec3::splat(2.0); 1200]);
    for bad in [f32::NAN, f32::NEG_INFINITY, -1.0] {
        let mask = gpu.float_mask(UVec2::new(4, 1), &[bad, bad, 0.5, 100.0]);
        for trim in [
            None,
            Some(LuminanceTrim {
                low: 0.0,
                high: 0.0,
            }),
        ] {
            let settings = LeanAutoExposure {
                pattern: MeteringPattern::Mask(Handle::default()),
                trim,
                ..instant()
            };
            for path in paths(&gpu) {
                let whole = (UVec2::ZERO, size);
                let meter = Meter::new(&gpu, &settings, path, &texture, whole, Some(&mask));
                let state = meter.frame(0.1, 0);
                assert!(
                    (state.luminance / 2.0).log2().abs() <= 0.06,
                    "{bad}: {state:?}"
                );
            }
        }
    }
}

/// The error of trimming is half a bin of the histogram, plus the bin's coarseness at the limits of the shares.
#[test]
fn trimming() {
    let gpu = ExposureGpu::new();
    for (low, high) in [(0.0, 0.0), (0.1, 0.1), (0.5, 0.4), (0.0, 0.95), (0.9, 0.0)] {
        let settings = LeanAutoExposure {
            trim: Some(LuminanceTrim { low, high }),
            ..instant()
        };
        let stops = (1.0 + worst_error(&gpu, &settings, None)).log2();
        println!("without {low} and {high}: off by up to {stops:.3} stops");
        assert!(stops <= 0.06);
    }
    let all = LeanAutoExposure {
        trim: Some(LuminanceTrim {
            low: 0.6,
            high: 0.6,
        }),
        ..instant()
    };
    let size = UVec2::new(20, 10);
    let texture = gpu.picture(size, &picture(size, EASY[1].1));
    for path in paths(&gpu) {
        let state = Meter::new(&gpu, &all, path, &texture, (UVec2::ZERO, size), None).frame(0.1, 0);
        assert_eq!(state.exposure, 0.0, "nothing is left");
    }
}

/// The histogram of a frame holds nothing of the previous frame.
#[test]
fn histograms_are_of_one_frame() {
    let gpu = ExposureGpu::new();
    let size = UVec2::new(50, 30);
    let settings = LeanAutoExposure {
        trim: Some(LuminanceTrim {
            low: 0.0,
            high: 0.0,
        }),
        ..instant()
    };
    let grey = |value: f32| vec![Vec3::splat(value); size.element_product() as usize];
    for path in paths(&gpu) {
        let texture = gpu.picture(size, &grey(8.0));
        let meter = Meter::new(&gpu, &settings, path, &texture, (UVec2::ZERO, size), None);
        for value in [8.0f32, 0.25, 2.0] {
            gpu.overwrite(&texture, &grey(value));
            let state = meter.frame(0.1, 0);
            assert!((state.luminance / value).log2().abs() <= 0.06);
            assert_eq!(state.exposure, state.target_exposure, "it is instant");
        }
    }
}

/// Bins hold the pixels of an 8192×8192 picture without overflow: a quarter is 1, the rest is 4.
#[test]
fn histograms_do_not_overflow() {
    let gpu = ExposureGpu::new();
    let size = UVec2::splat(8192);
    if gpu.device.limits().max_texture_dimension_2d < size.x {
        println!("skipped: a picture of {size}: the device has no such textures");
        return;
    }
    let mut texels = vec![Vec3::ONE; size.element_product() as usize];
    let quarter = texels.len() / 4;
    texels[quarter..].fill(Vec3::splat(4.0));
    let texture = gpu.picture(size, &texels);
    let settings = LeanAutoExposure {
        trim: Some(LuminanceTrim {
            low: 0.0,
            high: 0.0,
        }),
        ..instant()
    };
    for path in paths(&gpu) {
        let state =
            Meter::new(&gpu, &settings, path, &texture, (UVec2::ZERO, size), None).frame(0.1, 0);
        assert!((state.luminance.log2() - 1.5).abs() <= 0.06, "{state:?}");
    }
}
