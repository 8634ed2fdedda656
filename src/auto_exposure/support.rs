//! What the device can do.

use bevy::{
    prelude::*,
    render::{
        render_resource::DownlevelFlags,
        renderer::{RenderAdapter, RenderAdapterInfo, RenderDevice},
    },
};

use super::{LeanAutoExposure, ReductionPath};

/// Below this a subgroup saves no step of the tree.
const SMALLEST_SUBGROUP: u32 = 4;

/// Whether and how this device can meter.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct ExposureSupport {
    /// What is missing; then the effect is off.
    pub missing: Option<String>,
    /// Smallest size of a subgroup; 0 if the device has no subgroup arithmetic.
    pub subgroup_size: u32,
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
        let has_subgroups = device.features().contains(wgpu::Features::SUBGROUP);
        Self {
            missing,
            subgroup_size: if has_subgroups {
                info.subgroup_min_size
            } else {
                0
            },
        }
    }

    /// Whether a camera with `settings` meters by subgroups.
    pub(super) fn uses_subgroups(&self, settings: &LeanAutoExposure) -> bool {
        match settings.reduction {
            // The histogram is faster without: see the bench.
            ReductionPath::Auto => {
                self.subgroup_size >= SMALLEST_SUBGROUP && settings.trim.is_none()
            }
            ReductionPath::Subgroup => self.subgroup_size > 0,
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
