//! Capabilities of the device.

use bevy::{
    prelude::*,
    render::{
        render_resource::DownlevelFlags,
        renderer::{RenderAdapter, RenderDevice},
    },
};

use super::settings::{LeanAutoExposure, ReductionPath};
use crate::gpu::{
    needed_limits::{NeededLimit, check_limits, needed_limits},
    subgroups::Subgroups,
};

/// Limits that metering needs.
#[doc(hidden)]
pub const NEEDED_LIMITS: &[NeededLimit] = &needed_limits![
    max_compute_invocations_per_workgroup: 256,
    max_compute_workgroup_size_x: 256,
    max_compute_workgroup_storage_size: 2048,
    max_storage_buffers_per_shader_stage: 4,
];

/// Checks the device of `world` for what metering needs.
pub(super) fn check(world: &World) -> Result<(), String> {
    let (Some(device), Some(adapter)) = (
        world.get_resource::<RenderDevice>(),
        world.get_resource::<RenderAdapter>(),
    ) else {
        return Err("a render device".into());
    };
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(DownlevelFlags::COMPUTE_SHADERS) {
        return Err("compute shaders".into());
    }
    let limits = device.limits();
    check_limits(NEEDED_LIMITS, &limits)?;
    if limits.min_storage_buffer_offset_alignment > limits.min_uniform_buffer_offset_alignment {
        // Bevy lays views out as uniforms, and the second pass writes the exposure into them as storage.
        return Err("storage buffers at the offsets of uniforms".into());
    }
    Ok(())
}

/// True if a camera with `settings` is metered by subgroups.
pub(super) fn uses_subgroups(subgroups: Subgroups, settings: &LeanAutoExposure) -> bool {
    match settings.advanced.reduction {
        // The bench measures the histogram faster without subgroups.
        ReductionPath::Auto => subgroups.are_useful() && settings.trim.is_none(),
        ReductionPath::Subgroup => subgroups.exist(),
        ReductionPath::SharedMemory => false,
    }
}
