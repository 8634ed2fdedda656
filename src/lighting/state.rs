//! The state of the lighting pass of a view.

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            BindGroup, CachedComputePipelineId, StorageBuffer, TextureView, TextureViewId,
        },
        renderer::RenderDevice,
    },
};

use super::{
    features::LightingKey, forward::OwnGroups, light_layer_table::LightLayersTable,
    parts::LightingParts, tile_list::TileList,
};
use crate::gpu::bind_group_cache::CachedBindGroup;

/// On a view: the state of its lighting pass. Removed with [`LeanDeferred`](crate::LeanDeferred).
#[doc(hidden)]
#[derive(Component, Default)]
pub struct ViewLighting {
    /// Keys and pipelines of this frame, the one for plain surfaces first.
    pub(crate) pipelines: Vec<(LightingKey, CachedComputePipelineId)>,
    /// Number of lean frames so far.
    pub(crate) frames: u32,
    /// The parts that the view needs.
    pub(crate) parts: LightingParts,
    pub(super) tile_list: Option<TileList>,
    pub(super) light_layers: Option<StorageBuffer<LightLayersTable>>,
    pub(super) bindings: ViewLightingBindings,
    /// For meshes that Bevy's passes draw.
    pub(super) forward_groups: OwnGroups,
}

impl ViewLighting {
    /// Bytes of its buffers.
    pub(super) fn bytes(&self) -> u64 {
        let tiles = self.tile_list.as_ref().map_or(0, |list| list.bytes());
        let layers = self.light_layers.as_ref();
        let layers = layers.and_then(|layers| layers.buffer());
        tiles + layers.map_or(0, |buffer| buffer.size())
    }

    /// Recreates the tile list if its capacity is too small, and drops it if the dispatch over all tiles, with this `key`, fills
    /// none.
    pub(super) fn update_tile_list(
        &mut self,
        device: &RenderDevice,
        key: LightingKey,
        capacity: u32,
    ) {
        if !key.lists {
            self.tile_list = None;
        } else if !(self.tile_list.as_ref()).is_some_and(|list| list.fits(capacity)) {
            self.tile_list = Some(TileList::new(device, capacity));
        }
    }

    /// Bind groups that are kept until a bound resource is replaced: light probes and decals, the tile list, and the G-buffer
    /// with either main texture. The group of the view is not among them: Bevy recreates the buffers of the light clusters in
    /// each frame.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        self.bindings.lasting()
    }

    /// Number of bound textures of light probes and decals.
    pub fn textures_in_arrays(&self) -> usize {
        self.bindings.textures_in_arrays()
    }

    /// True if general pipelines light the view.
    pub fn is_general(&self) -> bool {
        let first = self.pipelines.first();
        first.is_some_and(|(key, _)| key.is_general)
    }
}

/// The bind groups of one view, with the other arguments of its dispatches.
#[derive(Default)]
pub(super) struct ViewLightingBindings {
    pub(super) view: CachedBindGroup,
    pub(super) view_offsets: Vec<u32>,
    pub(super) arrays: CachedBindGroup,
    /// Post-processing swaps the two main textures, also between cameras of one target, so each has its group.
    pub(super) targets: [(Option<TextureViewId>, CachedBindGroup); 2],
    /// The tile list, to fill and to read. Empty without special surfaces.
    pub(super) fill_list: CachedBindGroup,
    pub(super) read_list: CachedBindGroup,
    /// Offsets of the uniform without and with `writes_background`.
    pub(super) uniform_offsets: [u32; 2],
    pub(super) viewport_size: UVec2,
    /// True if the viewport is the whole render target.
    pub(super) covers_target: bool,
}

impl ViewLightingBindings {
    /// The group that writes into `main_texture`.
    pub(super) fn targets_for(&self, main_texture: &TextureView) -> Option<&BindGroup> {
        self.targets
            .iter()
            .find(|(id, _)| *id == Some(main_texture.id()))
            .and_then(|(_, group)| group.get())
    }

    /// All bind groups except that of the view.
    fn lasting(&self) -> impl Iterator<Item = &BindGroup> {
        let targets = self.targets.iter().map(|(_, group)| group);
        [&self.arrays, &self.fill_list, &self.read_list]
            .into_iter()
            .chain(targets)
            .filter_map(CachedBindGroup::get)
    }

    /// Number of bound textures of light probes and decals.
    fn textures_in_arrays(&self) -> usize {
        self.arrays.texture_views()
    }

    pub(super) fn clear(&mut self) {
        self.view.clear();
        self.arrays.clear();
        self.targets = default();
        self.fill_list.clear();
        self.read_list.clear();
    }
}
