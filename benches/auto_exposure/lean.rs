//! This crate's auto exposure, outside any app.

use bevy::{asset::Handle, math::UVec2};
use bevy_lean_deferred::effects::auto_exposure::{LeanAutoExposure, Metering, MeteringPattern};

use crate::{
    Args,
    picture::{TRIM, mask},
    ring::Ring,
    timing::{Measured, time},
};
use kit::{
    exposure_gpu::{ExposureGpu, Meter},
    lean::instant_exposure,
};

/// Settings, by name.
pub fn contenders() -> Vec<(String, LeanAutoExposure)> {
    let base = instant_exposure();
    let mut all = Vec::new();
    for metering in [Metering::LogAverage, Metering::LinearAverage] {
        all.push((
            format!("{metering:?}"),
            LeanAutoExposure {
                metering,
                ..base.clone()
            },
        ));
    }
    let patterned = |pattern| LeanAutoExposure {
        pattern,
        ..base.clone()
    };
    all.extend([
        (
            "LogAverage, CenterWeighted".into(),
            patterned(MeteringPattern::CenterWeighted),
        ),
        (
            "LogAverage, Mask".into(),
            patterned(MeteringPattern::Mask(Handle::default())),
        ),
        (
            "LogAverage, trim".into(),
            LeanAutoExposure {
                trim: Some(TRIM),
                ..base.clone()
            },
        ),
    ]);
    all
}

/// Times the passes over `ring`. Each picture has its own buffers.
pub fn measure(
    gpu: &ExposureGpu,
    ring: &Ring,
    settings: &LeanAutoExposure,
    subgroups: bool,
    args: &Args,
) -> Measured {
    let mask = matches!(settings.pattern, MeteringPattern::Mask(_)).then(|| {
        let mask = mask();
        gpu.mask(mask.size, &mask.texels)
    });
    let mask = mask.as_ref();
    let size = ring.0[0].size();
    let viewport = (UVec2::ZERO, UVec2::new(size.width, size.height));
    let first = Meter::new(gpu, settings, subgroups, &ring.0[0], viewport, mask);
    let others: Vec<Meter> = ring.0[1..]
        .iter()
        .map(|picture| first.another(picture, mask))
        .collect();
    let meters: Vec<&Meter> = core::iter::once(&first).chain(&others).collect();
    for meter in &meters {
        meter.prepare(0.1, 0);
    }
    let passes = time(gpu, 2, args, |frame, index, encoder, timestamps| {
        let mut pass = encoder.begin_compute_pass(&timestamps.of_pass(index));
        meters[frame % meters.len()].dispatch(&mut pass, index);
    });
    let whole = time(gpu, 1, args, |frame, index, encoder, timestamps| {
        let mut pass = encoder.begin_compute_pass(&timestamps.of_pass(index));
        for dispatch in 0..2 {
            meters[frame % meters.len()].dispatch(&mut pass, dispatch);
        }
    });
    Measured {
        passes,
        whole: whole.first().copied(),
        luminance: first.state().luminance.into(),
    }
}
