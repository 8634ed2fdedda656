//! Capabilities of the device that GI and reflections need.

use bevy::{prelude::*, render::renderer::RenderDevice};

use crate::gpu::needed_limits::{NeededLimit, check_limits, needed_limits};

/// Limits that GI and reflections need, in addition to those of [`LeanDeferred`](crate::LeanDeferred).
#[doc(hidden)]
pub const NEEDED_LIMITS: &[NeededLimit] = &needed_limits![
    max_compute_invocations_per_workgroup: 256,
    max_compute_workgroup_size_x: 256,
    max_compute_workgroup_storage_size: 12544,
];

/// Checks the device of `world` for limits that lean cameras do not need.
pub(super) fn check(world: &World) -> Result<(), String> {
    check_device_limits(world, NEEDED_LIMITS)
}

/// Checks the device of `world` for `needed` limits.
pub(super) fn check_device_limits(world: &World, needed: &[NeededLimit]) -> Result<(), String> {
    match world.get_resource::<RenderDevice>() {
        Some(device) => check_limits(needed, &device.limits()),
        None => Err("a render device".into()),
    }
}
