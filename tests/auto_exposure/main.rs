//! Auto exposure: what is metered, how exposure follows, and that nothing spoils its history.

mod cameras;
mod history;
mod metering;
mod pictures;
mod reduction;
mod resources;

use bevy_lean_deferred::{auto_exposure::LeanAutoExposure, prelude::*};
use kit::exposure_gpu::ExposureGpu;

const METERINGS: [Metering; 2] = [Metering::LogAverage, Metering::LinearAverage];

/// No adaptation.
fn instant() -> LeanAutoExposure {
    LeanAutoExposure {
        instant: true,
        ..Default::default()
    }
}

/// Whether to reduce by subgroups: both, where the device has them.
fn paths(gpu: &ExposureGpu) -> Vec<bool> {
    if gpu.has_subgroups() {
        vec![false, true]
    } else {
        vec![false]
    }
}
