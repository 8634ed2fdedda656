//! Auto exposure: what is metered, how exposure follows, and that nothing spoils its history.

#[path = "auto_exposure/cameras.rs"]
mod cameras;
mod common;
#[path = "auto_exposure/history.rs"]
mod history;
#[path = "auto_exposure/metering.rs"]
mod metering;
#[path = "auto_exposure/pictures.rs"]
mod pictures;
#[path = "auto_exposure/reduction.rs"]
mod reduction;
#[path = "auto_exposure/reference.rs"]
mod reference;
#[path = "auto_exposure/resources.rs"]
mod resources;

use bevy_lean_deferred::{auto_exposure::LeanAutoExposure, prelude::*};
use common::exposure_gpu::ExposureGpu;

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
