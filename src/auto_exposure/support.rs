//! Capabilities of the device.

use bevy::{
    prelude::*,
    render::{
        render_resource::DownlevelFlags,
        renderer::{RenderAdapter, RenderAdapterInfo, RenderDevice},
    },
};

use super::{LeanAutoExposure, ReductionPath};
use crate::gpu::{
    needed_limits::{NeededLimit, needed_limits, unmet},
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

/// Support for metering on this device. Exists in the main world from before `Startup` on, and in the render world from
/// `RenderStartup` on.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct ExposureSupport {
    /// Missing capability; the effect is off if there is one.
    pub missing: Option<String>,
    pub(crate) subgroups: Subgroups,
}

impl ExposureSupport {
    fn from_world(world: &World) -> Self {
        let (Some(device), Some(adapter), Some(info)) = (
            world.get_resource::<RenderDevice>(),
            world.get_resource::<RenderAdapter>(),
            world.get_resource::<RenderAdapterInfo>(),
        ) else {
            return Self {
                missing: Some("a render device".into()),
                ..default()
            };
        };
        let limits = device.limits();
        let computes = adapter
            .get_downlevel_capabilities()
            .flags
            .contains(DownlevelFlags::COMPUTE_SHADERS);
        let missing = if !computes {
            Some("compute shaders".into())
        } else if let Some(limit) = unmet(NEEDED_LIMITS, &limits).next() {
            Some(format!("{limit} (it has {})", limit.of(&limits)))
        } else if limits.min_storage_buffer_offset_alignment
            > limits.min_uniform_buffer_offset_alignment
        {
            // Bevy lays views out as uniforms, and the second pass writes the exposure into them as storage.
            Some("storage buffers at the offsets of uniforms".into())
        } else {
            None
        };
        Self {
            missing,
            subgroups: Subgroups::of(device, info),
        }
    }

    /// True if a camera with `settings` is metered by subgroups.
    pub(super) fn uses_subgroups(&self, settings: &LeanAutoExposure) -> bool {
        match settings.advanced.reduction {
            // The histogram is faster without subgroups, by the bench.
            ReductionPath::Auto => self.subgroups.are_useful() && settings.trim.is_none(),
            ReductionPath::Subgroup => self.subgroups.exist(),
            ReductionPath::SharedMemory => false,
        }
    }
}

/// Inserts [`ExposureSupport`] into the main world; true if the device can meter.
pub(super) fn tell_main_world(world: &mut World) -> bool {
    let support = ExposureSupport::from_world(world);
    let can_meter = support.missing.is_none();
    world.insert_resource(support);
    can_meter
}

/// Queries each new device. Runs in the render world.
pub(super) fn init_exposure_support(world: &mut World) {
    let support = ExposureSupport::from_world(world);
    if let Some(missing) = &support.missing {
        warn!("LeanAutoExposure is off on all cameras: the device lacks {missing}.");
    }
    world.insert_resource(support);
}
