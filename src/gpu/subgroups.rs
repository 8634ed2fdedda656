//! Detects subgroup operations of the device.

use bevy::{
    prelude::*,
    render::renderer::{RenderAdapterInfo, RenderDevice},
};

/// Smaller subgroups save hardly any time.
const SMALLEST_USEFUL: u32 = 4;

/// Subgroup operations of the device.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Subgroups {
    /// Invocations of the smallest subgroup; 0 if shaders have no subgroup operations.
    pub(crate) smallest: u32,
}

impl Subgroups {
    pub(crate) fn from_world(world: &World) -> Self {
        match (
            world.get_resource::<RenderDevice>(),
            world.get_resource::<RenderAdapterInfo>(),
        ) {
            (Some(device), Some(info)) => Self::of(device, info),
            _ => Self::default(),
        }
    }

    pub(crate) fn of(device: &RenderDevice, info: &RenderAdapterInfo) -> Self {
        let has_subgroups = device.features().contains(wgpu::Features::SUBGROUP);
        Self {
            smallest: if has_subgroups {
                info.subgroup_min_size
            } else {
                0
            },
        }
    }

    pub(crate) fn exist(self) -> bool {
        self.smallest > 0
    }

    /// True if subgroups are large enough to save time.
    pub(crate) fn are_useful(self) -> bool {
        self.smallest >= SMALLEST_USEFUL
    }
}
