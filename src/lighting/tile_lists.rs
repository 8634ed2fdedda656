//! Lists of the tiles that have pixels of each special kind, which the first dispatch fills on the GPU, and the
//! indirect dispatches over them. Twin of `tile_lists.wgsl`.

use bevy::render::{
    render_resource::{
        BindGroupLayoutDescriptor, Buffer, BufferDescriptor, BufferInitDescriptor, BufferUsages,
        CommandEncoder, ShaderStages,
        binding_types::{storage_buffer_read_only_sized, storage_buffer_sized},
    },
    renderer::RenderDevice,
};

use super::binding_numbers::lists;
use crate::{
    gpu::bindings::layout,
    view::{LightingVariant, LightingVariants},
};

/// Variants that can be told apart.
const VARIANTS: u64 = 16;
/// Bytes of `x`, `y`, `z` of an indirect dispatch.
const DISPATCH_SIZE: u64 = 12;

/// The lists of one view.
pub(super) struct TileLists {
    listed: LightingVariants,
    capacity: u32,
    /// An indirect dispatch for each variant.
    dispatches: Buffer,
    /// A counter for each variant, then a list for each that is listed.
    lists: Buffer,
}

impl TileLists {
    /// Lists of up to `capacity` tiles.
    pub(super) fn new(device: &RenderDevice, listed: LightingVariants, capacity: u32) -> Self {
        let dispatches = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("lean_deferred/lighting/dispatches"),
            contents: bytemuck::cast_slice(&[[0u32, 0, 1]; VARIANTS as usize]),
            usage: BufferUsages::STORAGE | BufferUsages::INDIRECT | BufferUsages::COPY_DST,
        });
        let lists = device.create_buffer(&BufferDescriptor {
            label: Some("lean_deferred/lighting/lists"),
            size: 4 * (VARIANTS + u64::from(listed.count()) * u64::from(capacity)),
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            listed,
            capacity,
            dispatches,
            lists,
        }
    }

    /// Whether they are what `new` would make.
    pub(super) fn fit(&self, listed: LightingVariants, capacity: u32) -> bool {
        self.listed == listed && self.capacity == capacity
    }

    /// Empties the lists.
    pub(super) fn clear(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.lists, 0, Some(4 * VARIANTS));
        for variant in self.listed.each() {
            let dispatch = self.dispatch_offset(variant);
            encoder.clear_buffer(&self.dispatches, dispatch, Some(8));
        }
    }

    pub(super) fn dispatches(&self) -> &Buffer {
        &self.dispatches
    }

    pub(super) fn lists(&self) -> &Buffer {
        &self.lists
    }

    /// Where in [`dispatches`](Self::dispatches) that of `variant` stands.
    pub(super) fn dispatch_offset(&self, variant: LightingVariant) -> u64 {
        u64::from(variant.index()) * DISPATCH_SIZE
    }
}

/// What the dispatch that fills the lists binds of them.
pub(super) fn filling_layout() -> BindGroupLayoutDescriptor {
    layout(
        "lean_deferred/lighting/fill_lists",
        ShaderStages::COMPUTE,
        [
            (lists::DISPATCHES, storage_buffer_sized(false, None)),
            (lists::LISTS, storage_buffer_sized(false, None)),
        ],
    )
}

/// What a dispatch over a list binds of them.
pub(super) fn reading_layout() -> BindGroupLayoutDescriptor {
    layout(
        "lean_deferred/lighting/read_lists",
        ShaderStages::COMPUTE,
        [(lists::LISTS, storage_buffer_read_only_sized(false, None))],
    )
}
