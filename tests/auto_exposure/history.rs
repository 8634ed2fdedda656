//! Exposure over time, as it follows the metered luminance.

use bevy::math::{UVec2, Vec3};
use bevy_lean_deferred::effects::auto_exposure::{
    ExposureState, LeanAutoExposure, LeanAutoExposureAdvanced, LuminanceTrim, Metering,
};

use crate::{
    instant, paths,
    pictures::{HOSTILE, picture},
};
use kit::{
    exposure_gpu::{ExposureGpu, Meter},
    reference::effects::auto_exposure::adaptation::{adapted, covered},
};

const SIZE: UVec2 = UVec2::new(19, 11);

fn grey(value: f32) -> Vec<Vec3> {
    vec![Vec3::splat(value); SIZE.element_product() as usize]
}

/// Exposure after a frame, by the documented formula.
fn expected(
    settings: &LeanAutoExposure,
    last: &ExposureState,
    now: &ExposureState,
    seconds: f32,
) -> f32 {
    adapted(
        last.exposure,
        now.target_exposure,
        seconds,
        settings.speed_brighten,
        settings.speed_darken,
        settings.advanced.transition,
    )
}

/// The first frame is adapted; brightness steps follow the curve within 1% of a step; a cut skips it.
#[test]
fn steps_follow_the_documented_curve() {
    let gpu = ExposureGpu::new();
    for path in paths(&gpu) {
        for (settings, seconds) in [
            (LeanAutoExposure::default(), 1.0 / 60.0),
            (LeanAutoExposure::default(), 0.1),
            (
                LeanAutoExposure {
                    speed_brighten: 10.0,
                    advanced: LeanAutoExposureAdvanced {
                        transition: 0.0,
                        ..Default::default()
                    },
                    ..Default::default()
                },
                0.004,
            ),
        ] {
            let texture = gpu.picture(SIZE, &grey(0.18));
            let meter = Meter::new(&gpu, &settings, path, &texture, (UVec2::ZERO, SIZE), None);
            let mut state = meter.frame(seconds, 0);
            assert_eq!(state.exposure, state.target_exposure);
            assert!(state.exposure.abs() < 1e-3);
            for brightness in [0.18 * 16.0, 0.18 / 16.0] {
                gpu.overwrite(&texture, &grey(brightness));
                let start = state.exposure;
                let mut worst = 0.0f32;
                for frame in 1..=60u16 {
                    let last = state;
                    state = meter.frame(seconds, 0);
                    worst = worst
                        .max((state.exposure - expected(&settings, &last, &state, seconds)).abs());
                    // Also from the step's beginning in a single interval.
                    let whole = expected(
                        &settings,
                        &ExposureState {
                            exposure: start,
                            ..state
                        },
                        &state,
                        seconds * f32::from(frame),
                    );
                    worst = worst.max((state.exposure - whole).abs());
                    assert!(
                        (state.exposure - state.target_exposure).abs()
                            <= (last.exposure - state.target_exposure).abs()
                    );
                }
                println!("{seconds} s: off the curve by up to {worst:.1e} stops");
                assert!(worst <= 0.01 * 4.0);
            }
            gpu.overwrite(&texture, &grey(0.18));
            let cut = meter.frame(seconds, 1);
            assert_eq!(cut.exposure, cut.target_exposure);
        }
    }
}

/// A frame of no duration keeps the exposure, and none of any duration overshoots.
#[test]
fn frames_may_take_any_time() {
    let gpu = ExposureGpu::new();
    let settings = LeanAutoExposure {
        speed_darken: 3.0,
        ..Default::default()
    };
    for path in paths(&gpu) {
        for seconds in [0.0, 1e-4, 0.1, 10.0, 1e9, f32::INFINITY, f32::NAN, -1.0] {
            let texture = gpu.picture(SIZE, &grey(2.0));
            let meter = Meter::new(&gpu, &settings, path, &texture, (UVec2::ZERO, SIZE), None);
            let before = meter.frame(1.0, 0).exposure;
            gpu.overwrite(&texture, &grey(0.02));
            let after = meter.frame(seconds, 0);
            println!(
                "{seconds} s: {before} to {} of {}",
                after.exposure, after.target_exposure
            );
            assert!(before <= after.exposure && after.exposure <= after.target_exposure);
            if seconds.is_nan() || seconds <= 0.0 {
                assert_eq!(after.exposure, before);
            }
            if seconds >= 10.0 {
                assert!(after.target_exposure - after.exposure < 1e-3);
            }
        }
    }
}

/// A thousand pictures of random bits keep the exposure within its bounds, and it still adapts to valid pictures afterwards.
#[test]
fn noise_never_spoils_the_history() {
    let gpu = ExposureGpu::new();
    let settings = LeanAutoExposure::default();
    for path in paths(&gpu) {
        let texture = gpu.picture(SIZE, &grey(f32::NAN));
        let meter = Meter::new(&gpu, &settings, path, &texture, (UVec2::ZERO, SIZE), None);
        let (mut least, mut most) = (f32::MAX, f32::MIN);
        for frame in 0..1000 {
            // Another strip of the noise in each frame.
            let (_, texel) = HOSTILE[frame % HOSTILE.len()];
            let noise = picture(UVec2::new(SIZE.x, SIZE.y + frame as u32 % 50), texel);
            gpu.overwrite(
                &texture,
                &noise[noise.len() - SIZE.element_product() as usize..],
            );
            let state = meter.frame(1.0 / 60.0, 0);
            assert!(state.luminance.is_finite());
            least = least.min(state.exposure);
            most = most.max(state.exposure);
        }
        println!("exposure between {least} and {most}");
        assert!(settings.range.contains(&least) && settings.range.contains(&most));
        gpu.overwrite(&texture, &grey(0.18));
        let mut state = meter.frame(1.0, 0);
        for _ in 0..60 {
            state = meter.frame(1.0, 0);
        }
        assert!(state.exposure.abs() < 1e-3);
    }
}

#[test]
fn black_has_the_largest_exposure_and_bright_the_least() {
    let gpu = ExposureGpu::new();
    for (value, expected) in [
        (0.0, 8.0),
        (-5.0, 8.0),
        (60_000.0, -8.0),
        (f32::INFINITY, -8.0),
    ] {
        for path in paths(&gpu) {
            let texture = gpu.picture(SIZE, &grey(value));
            let settings = LeanAutoExposure::default();
            let meter = Meter::new(&gpu, &settings, path, &texture, (UVec2::ZERO, SIZE), None);
            assert_eq!(meter.frame(0.1, 0).exposure, expected, "{value}");
        }
    }
}

/// NaN, infinite or contradictory settings keep the exposure finite.
#[test]
fn settings_may_be_hostile() {
    let gpu = ExposureGpu::new();
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e38];
    for value in bad {
        for other in bad {
            let settings = LeanAutoExposure {
                target: value,
                compensation: other,
                compensation_curve: vec![(value, other).into(), (other, value).into()],
                range: value..=other,
                speed_brighten: other,
                speed_darken: value,
                advanced: LeanAutoExposureAdvanced {
                    transition: other,
                    ..Default::default()
                },
                ..Default::default()
            };
            let texture = gpu.picture(SIZE, &grey(0.5));
            let meter = Meter::new(&gpu, &settings, false, &texture, (UVec2::ZERO, SIZE), None);
            for _ in 0..3 {
                let state = meter.frame(0.1, 0);
                assert!(state.exposure.is_finite(), "{settings:?}");
            }
        }
    }
}

/// The compensation curve is exact at its points, between them, and beyond them.
#[test]
fn compensation_curves_are_piecewise_linear() {
    let gpu = ExposureGpu::new();
    let points: [(f32, f32); 4] = [(-6.0, 1.0), (-2.0, 0.0), (0.0, 0.0), (4.0, -2.0)];
    let settings = LeanAutoExposure {
        compensation: 0.5,
        compensation_curve: points.map(Into::into).to_vec(),
        ..instant()
    };
    for (log_y, stops) in [
        (-9.0f32, 1.0),
        (-6.0, 1.0),
        (-4.0, 0.5),
        (-2.0, 0.0),
        (-1.0, 0.0),
        (1.0, -0.5),
        (4.0, -2.0),
        (6.0, -2.0),
    ] {
        let texture = gpu.picture(SIZE, &grey(log_y.exp2()));
        let meter = Meter::new(&gpu, &settings, false, &texture, (UVec2::ZERO, SIZE), None);
        let plain = (0.18f32.log2() - log_y).clamp(-8.0, 8.0);
        let compensation = meter.frame(0.1, 0).exposure - plain;
        assert!(
            (compensation - stops - 0.5).abs() < 1e-3,
            "at {log_y}: {compensation}"
        );
    }
}

/// Many short frames adapt as far as one long frame.
#[test]
fn adaptation_is_independent_of_the_frame_rate() {
    for start in [-6.0f32, -1.0, 0.5, 7.0] {
        for seconds in [0.0, 0.0001, 0.1, 1.0, 10.0] {
            let once = adapted(start, 1.0, seconds, 3.0, 1.0, 1.5);
            let mut often = start;
            for _ in 0..1000 {
                often = adapted(often, 1.0, seconds / 1000.0, 3.0, 1.0, 1.5);
            }
            assert!(
                (once - often).abs() < 2e-3,
                "{start} {seconds}: {once} {often}"
            );
            assert!((once - 1.0).abs() <= (start - 1.0).abs());
            assert!((once - 1.0) * (start - 1.0) >= 0.0, "it overshoots");
        }
    }
    assert_eq!(covered(3.0, 0.5, 2.0, 1.0), 1.0);
    assert!((covered(1.0, 1.0, 1.0, 1.0) - (1.0 - (-1.0f32).exp())).abs() < 1e-6);
}

/// Black frames while a scene loads, or after a cut, do not count: adaptation starts with the first light.
#[test]
fn black_before_the_first_light_does_not_count() {
    let gpu = ExposureGpu::new();
    let frame_time = 1.0 / 60.0;
    for path in paths(&gpu) {
        for (metering, trim) in [
            (Metering::LogAverage, None),
            (Metering::LinearAverage, None),
            (
                Metering::LogAverage,
                Some(LuminanceTrim {
                    low: 0.1,
                    high: 0.1,
                }),
            ),
        ] {
            let settings = LeanAutoExposure {
                metering,
                trim,
                ..Default::default()
            };
            for nothing in [0.0, f32::NAN] {
                let texture = gpu.picture(SIZE, &grey(nothing));
                let meter = Meter::new(&gpu, &settings, path, &texture, (UVec2::ZERO, SIZE), None);
                let name = format!("{metering:?}, {trim:?}, {nothing}");
                for cuts in 0..2 {
                    gpu.overwrite(&texture, &grey(nothing));
                    for _ in 0..30 {
                        meter.frame(frame_time, cuts);
                    }
                    gpu.overwrite(&texture, &grey(2.0));
                    let first = meter.frame(frame_time, cuts);
                    println!("{name}: {} in the first light", first.exposure);
                    assert_eq!(first.exposure, first.target_exposure, "{name}");
                    // Later darkness is adapted to as usual.
                    gpu.overwrite(&texture, &grey(0.0));
                    let night = meter.frame(frame_time, cuts);
                    let speed = settings.speed_darken * frame_time;
                    let step = night.exposure - first.exposure;
                    assert!((step / speed - 1.0).abs() < 0.01, "{name}: {step}");
                    gpu.overwrite(&texture, &grey(2.0));
                    let day = meter.frame(frame_time, cuts);
                    assert!(day.exposure <= night.exposure, "{name}");
                }
            }
        }
    }
}
