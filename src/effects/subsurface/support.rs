//! Requirements on the device.

use bevy::prelude::*;

use crate::{
    effects::support::check_device_limits,
    gpu::needed_limits::{NeededLimit, needed_limits, unmet},
};

/// Limits that scattering needs, in addition to those of [`LeanDeferred`](crate::LeanDeferred).
#[doc(hidden)]
pub const NEEDED_LIMITS: &[NeededLimit] = &needed_limits![
    // With scattering, lighting writes one buffer more.
    max_storage_buffers_per_shader_stage: 9,
    max_compute_invocations_per_workgroup: 256,
    max_compute_workgroup_size_x: 256,
    max_compute_workgroup_storage_size: 16352,
];

/// First limit that the device does not meet.
pub fn missing_for_scattering(limits: &wgpu::Limits) -> Option<&'static NeededLimit> {
    unmet(NEEDED_LIMITS, limits).next()
}

/// Checks the device of `world` for limits that lean cameras do not need.
pub(super) fn check(world: &World) -> Result<(), String> {
    check_device_limits(world, NEEDED_LIMITS)
}
