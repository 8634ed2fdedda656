//! The list of tiles with special surfaces, which the first dispatch fills on the GPU, and the arguments of the
//! indirect dispatch over it.

use bevy::render::{
    render_resource::{
        BindGroupLayoutDescriptor, Buffer, BufferDescriptor, BufferInitDescriptor, BufferUsages,
        CommandEncoder, ShaderStages,
        binding_types::{storage_buffer_read_only_sized, storage_buffer_sized},
    },
    renderer::RenderDevice,
};

use super::binding_numbers::list;
use crate::gpu::bindings::layout;

/// The list of one view.
pub(super) struct TileList {
    capacity: u32,
    dispatch: Buffer,
    /// A counter, followed by the tiles.
    list: Buffer,
}

impl TileList {
    /// Creates a list of up to `capacity` tiles.
    pub(super) fn new(device: &RenderDevice, capacity: u32) -> Self {
        let dispatch = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("lean_deferred/lighting/dispatch"),
            contents: bytemuck::cast_slice(&[0u32, 0, 1]),
            usage: BufferUsages::STORAGE | BufferUsages::INDIRECT | BufferUsages::COPY_DST,
        });
        let list = device.create_buffer(&BufferDescriptor {
            label: Some("lean_deferred/lighting/list"),
            size: 4 * (1 + u64::from(capacity)),
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            capacity,
            dispatch,
            list,
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.dispatch.size() + self.list.size()
    }

    /// True if the list has at least this capacity.
    pub(super) fn fits(&self, capacity: u32) -> bool {
        self.capacity >= capacity
    }

    pub(super) fn clear(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.list, 0, Some(4));
        // Clears x and y; z stays 1.
        encoder.clear_buffer(&self.dispatch, 0, Some(8));
    }

    pub(super) fn dispatch(&self) -> &Buffer {
        &self.dispatch
    }

    pub(super) fn list(&self) -> &Buffer {
        &self.list
    }
}

/// Bindings of the dispatch that fills the list.
pub(super) fn filling_layout() -> BindGroupLayoutDescriptor {
    layout(
        "lean_deferred/lighting/fill_list",
        ShaderStages::COMPUTE,
        [
            (list::DISPATCH, storage_buffer_sized(false, None)),
            (list::LIST, storage_buffer_sized(false, None)),
        ],
    )
}

/// Bindings of the dispatch over the list.
pub(super) fn reading_layout() -> BindGroupLayoutDescriptor {
    layout(
        "lean_deferred/lighting/read_list",
        ShaderStages::COMPUTE,
        [(list::LIST, storage_buffer_read_only_sized(false, None))],
    )
}
