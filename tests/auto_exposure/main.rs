//! Auto exposure: metering, adaptation, and robustness of its history.

mod cameras;
mod history;
mod metering;
mod pictures;
mod reduction;
mod resources;

use bevy_lean_deferred::effects::auto_exposure::Metering;
use kit::{exposure_gpu::ExposureGpu, lean::instant_exposure as instant};

const METERINGS: [Metering; 2] = [Metering::LogAverage, Metering::LinearAverage];

/// Paths of the reduction, true with subgroups: both if the device supports them.
fn paths(gpu: &ExposureGpu) -> Vec<bool> {
    if gpu.has_subgroups() {
        vec![false, true]
    } else {
        vec![false]
    }
}
