//! The items in the render phases of the G-buffer.

use core::ops::Range;

use bevy::{
    asset::AssetId,
    core_pipeline::core_3d::{Opaque3dBatchSetKey, Opaque3dBinKey},
    pbr::LightmapSlabIndex,
    prelude::*,
    render::{
        mesh::allocator::MeshSlabs,
        render_phase::{
            BinnedPhaseItem, BinnedRenderPhase, BinnedRenderPhaseType,
            CachedRenderPipelinePhaseItem, DrawFunctionId, InputUniformIndex, PhaseItem,
            PhaseItemBatchSetKey, PhaseItemExtraIndex,
        },
        render_resource::CachedRenderPipelineId,
        sync_world::MainEntity,
    },
};

/// Key of a multi-draw; all its meshes share it.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GBufferBatchSetKey {
    /// As in Bevy's opaque phase.
    pub mesh: Opaque3dBatchSetKey,
    /// The visibility mask that they write, if any.
    pub visibility_mask: Option<u32>,
}

impl PhaseItemBatchSetKey for GBufferBatchSetKey {
    fn indexed(&self) -> bool {
        self.mesh.indexed()
    }
}

/// Meshes of the G-buffer that are drawn together: opaque or alpha-masked, with the base targets alone or with optional
/// targets too.
pub struct GBufferItem<const ALPHA_MASKED: bool, const EXTENDED: bool> {
    /// Key that meshes of one multi-draw share.
    pub batch_set_key: GBufferBatchSetKey,
    /// An entity that represents the batch.
    pub representative_entity: (Entity, MainEntity),
    /// The instances.
    pub batch_range: Range<u32>,
    /// A dynamic offset, or an index into the indirect parameters.
    pub extra_index: PhaseItemExtraIndex,
}

/// Opaque meshes that write the base targets alone.
pub type OpaqueGBuffer = GBufferItem<false, false>;
/// Alpha-masked meshes that write the base targets alone.
pub type AlphaMaskGBuffer = GBufferItem<true, false>;
/// Opaque meshes that write optional targets too.
pub type ExtendedOpaqueGBuffer = GBufferItem<false, true>;
/// Alpha-masked meshes that write optional targets too.
pub type ExtendedAlphaMaskGBuffer = GBufferItem<true, true>;

impl<const ALPHA_MASKED: bool, const EXTENDED: bool> PhaseItem
    for GBufferItem<ALPHA_MASKED, EXTENDED>
{
    fn entity(&self) -> Entity {
        self.representative_entity.0
    }

    fn main_entity(&self) -> MainEntity {
        self.representative_entity.1
    }

    fn draw_function(&self) -> DrawFunctionId {
        self.batch_set_key.mesh.draw_function
    }

    fn batch_range(&self) -> &Range<u32> {
        &self.batch_range
    }

    fn batch_range_mut(&mut self) -> &mut Range<u32> {
        &mut self.batch_range
    }

    fn extra_index(&self) -> PhaseItemExtraIndex {
        self.extra_index.clone()
    }

    fn batch_range_and_extra_index_mut(&mut self) -> (&mut Range<u32>, &mut PhaseItemExtraIndex) {
        (&mut self.batch_range, &mut self.extra_index)
    }
}

impl<const ALPHA_MASKED: bool, const EXTENDED: bool> BinnedPhaseItem
    for GBufferItem<ALPHA_MASKED, EXTENDED>
{
    type BatchSetKey = GBufferBatchSetKey;
    type BinKey = Opaque3dBinKey;

    fn new(
        batch_set_key: Self::BatchSetKey,
        _bin_key: Self::BinKey,
        representative_entity: (Entity, MainEntity),
        batch_range: Range<u32>,
        extra_index: PhaseItemExtraIndex,
    ) -> Self {
        Self {
            batch_set_key,
            representative_entity,
            batch_range,
            extra_index,
        }
    }
}

impl<const ALPHA_MASKED: bool, const EXTENDED: bool> CachedRenderPipelinePhaseItem
    for GBufferItem<ALPHA_MASKED, EXTENDED>
{
    fn cached_pipeline(&self) -> CachedRenderPipelineId {
        self.batch_set_key.mesh.pipeline
    }
}

/// The data with which a mesh is added to a phase.
pub(super) struct QueuedMesh {
    /// The value that it writes to the visibility mask target, if any.
    pub(super) visibility_mask: Option<u32>,
    pub(super) pipeline: CachedRenderPipelineId,
    pub(super) draw_function: DrawFunctionId,
    pub(super) material_bind_group_index: Option<u32>,
    pub(super) slabs: MeshSlabs,
    pub(super) lightmap_slab: Option<LightmapSlabIndex>,
    pub(super) mesh: AssetId<Mesh>,
    pub(super) entities: (Entity, MainEntity),
    pub(super) uniform_index: InputUniformIndex,
    pub(super) phase_type: BinnedRenderPhaseType,
}

impl QueuedMesh {
    pub(super) fn add_to<P>(self, phase: &mut BinnedRenderPhase<P>)
    where
        P: BinnedPhaseItem<BatchSetKey = GBufferBatchSetKey, BinKey = Opaque3dBinKey>,
    {
        let key = GBufferBatchSetKey {
            mesh: Opaque3dBatchSetKey {
                pipeline: self.pipeline,
                draw_function: self.draw_function,
                material_bind_group_index: self.material_bind_group_index,
                slabs: self.slabs,
                lightmap_slab: self.lightmap_slab.map(|index| *index),
            },
            visibility_mask: self.visibility_mask,
        };
        let bin = Opaque3dBinKey {
            asset_id: self.mesh.into(),
        };
        phase.add(key, bin, self.entities, self.uniform_index, self.phase_type);
    }
}
