//! What the device can do.

use bevy::{
    prelude::*,
    render::{
        render_resource::DownlevelFlags,
        renderer::{RenderAdapter, RenderAdapterInfo, RenderDevice},
    },
};

use super::{LeanAutoExposure, ReductionPath};
use crate::gpu::subgroups::Subgroups;

/// Whether and how this device can meter.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct ExposureSupport {
    /// What is missing; then the effect is off.
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
        } else if limits.max_compute_invocations_per_workgroup < 256 {
            Some("workgroups of 256 invocations".into())
        } else if limits.max_storage_buffers_per_shader_stage < 4 {
            Some("4 storage buffers in a shader".into())
        } else if limits.min_storage_buffer_offset_alignment
            > limits.min_uniform_buffer_offset_alignment
        {
            // Bevy lays its views out as uniforms; the exposure is written into them.
            Some("storage buffers at the offsets of uniforms".into())
        } else {
            None
        };
        Self {
            missing,
            subgroups: Subgroups::of(device, info),
        }
    }

    /// Whether a camera with `settings` meters by subgroups.
    pub(super) fn uses_subgroups(&self, settings: &LeanAutoExposure) -> bool {
        match settings.reduction {
            // The histogram is faster without: see the bench.
            ReductionPath::Auto => self.subgroups.are_useful() && settings.trim.is_none(),
            ReductionPath::Subgroup => self.subgroups.exist(),
            ReductionPath::SharedMemory => false,
        }
    }
}

/// Looks at the device, each time there is a new one.
pub(super) fn init_exposure_support(world: &mut World) {
    let support = ExposureSupport::from_world(world);
    if let Some(missing) = &support.missing {
        warn!("LeanAutoExposure is off. The device lacks: {missing}");
    }
    world.insert_resource(support);
}
