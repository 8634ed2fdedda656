//! The render phases of the G-buffer: opaque and alpha-masked meshes, each with and without optional targets.

use core::ops::Range;

use bevy::{
    asset::AssetId,
    core_pipeline::core_3d::{Opaque3dBatchSetKey, Opaque3dBinKey},
    ecs::system::SystemParam,
    pbr::LightmapSlabIndex,
    platform::collections::HashSet,
    prelude::*,
    render::{
        Extract,
        batching::gpu_preprocessing::{GpuPreprocessingMode, GpuPreprocessingSupport},
        mesh::allocator::MeshSlabs,
        render_phase::{
            BinnedPhaseItem, BinnedRenderPhase, BinnedRenderPhaseType,
            CachedRenderPipelinePhaseItem, DrawFunctionId, InputUniformIndex, PhaseItem,
            PhaseItemBatchSetKey, PhaseItemExtraIndex, ViewBinnedRenderPhases,
        },
        render_resource::CachedRenderPipelineId,
        sync_world::MainEntity,
        view::{NoIndirectDrawing, RetainedViewEntity},
    },
};

use crate::view::LeanDeferred;

/// What meshes must have in common to be drawn by one multi-draw.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GBufferBatchSetKey {
    /// As in Bevy's opaque phase.
    pub mesh: Opaque3dBatchSetKey,
    /// The visibility mask that they write, if they write any.
    pub visibility_mask: Option<u32>,
}

impl PhaseItemBatchSetKey for GBufferBatchSetKey {
    fn indexed(&self) -> bool {
        self.mesh.indexed()
    }
}

/// A phase item whose meshes have one visibility mask.
pub(super) trait MaskedItem: PhaseItem {
    fn visibility_mask(&self) -> Option<u32>;
}

/// Declares a binned phase item keyed like Bevy's opaque phase.
macro_rules! gbuffer_phase {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        pub struct $name {
            /// What must be equal to be drawn by one multi-draw.
            pub batch_set_key: GBufferBatchSetKey,
            /// What must be equal to be drawn as instances.
            pub bin_key: Opaque3dBinKey,
            /// An entity that stands for the batch.
            pub representative_entity: (Entity, MainEntity),
            /// The instances.
            pub batch_range: Range<u32>,
            /// A dynamic offset, or an index into the indirect parameters.
            pub extra_index: PhaseItemExtraIndex,
        }

        impl PhaseItem for $name {
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

            fn batch_range_and_extra_index_mut(
                &mut self,
            ) -> (&mut Range<u32>, &mut PhaseItemExtraIndex) {
                (&mut self.batch_range, &mut self.extra_index)
            }
        }

        impl BinnedPhaseItem for $name {
            type BatchSetKey = GBufferBatchSetKey;
            type BinKey = Opaque3dBinKey;

            fn new(
                batch_set_key: Self::BatchSetKey,
                bin_key: Self::BinKey,
                representative_entity: (Entity, MainEntity),
                batch_range: Range<u32>,
                extra_index: PhaseItemExtraIndex,
            ) -> Self {
                Self {
                    batch_set_key,
                    bin_key,
                    representative_entity,
                    batch_range,
                    extra_index,
                }
            }
        }

        impl MaskedItem for $name {
            fn visibility_mask(&self) -> Option<u32> {
                self.batch_set_key.visibility_mask
            }
        }

        impl CachedRenderPipelinePhaseItem for $name {
            fn cached_pipeline(&self) -> CachedRenderPipelineId {
                self.batch_set_key.mesh.pipeline
            }
        }
    };
}

gbuffer_phase! {
    /// Opaque meshes that write the base targets alone.
    OpaqueGBuffer
}

gbuffer_phase! {
    /// Alpha-masked meshes that write the base targets alone.
    AlphaMaskGBuffer
}

gbuffer_phase! {
    /// Opaque meshes that write optional targets too.
    ExtendedOpaqueGBuffer
}

gbuffer_phase! {
    /// Alpha-masked meshes that write optional targets too.
    ExtendedAlphaMaskGBuffer
}

/// The phases of all views.
#[derive(SystemParam)]
pub(super) struct GBufferPhases<'w> {
    opaque: ResMut<'w, ViewBinnedRenderPhases<OpaqueGBuffer>>,
    alpha_mask: ResMut<'w, ViewBinnedRenderPhases<AlphaMaskGBuffer>>,
    extended_opaque: ResMut<'w, ViewBinnedRenderPhases<ExtendedOpaqueGBuffer>>,
    extended_alpha_mask: ResMut<'w, ViewBinnedRenderPhases<ExtendedAlphaMaskGBuffer>>,
}

/// The phases of all views, to be drawn.
#[derive(SystemParam)]
pub(super) struct DrawnGBufferPhases<'w> {
    pub(super) opaque: Res<'w, ViewBinnedRenderPhases<OpaqueGBuffer>>,
    pub(super) alpha_mask: Res<'w, ViewBinnedRenderPhases<AlphaMaskGBuffer>>,
    pub(super) extended_opaque: Res<'w, ViewBinnedRenderPhases<ExtendedOpaqueGBuffer>>,
    pub(super) extended_alpha_mask: Res<'w, ViewBinnedRenderPhases<ExtendedAlphaMaskGBuffer>>,
}

impl DrawnGBufferPhases<'_> {
    /// All that are written.
    pub(super) fn visibility_masks(&self) -> HashSet<u32> {
        fn of<P: BinnedPhaseItem<BatchSetKey = GBufferBatchSetKey>>(
            phases: &ViewBinnedRenderPhases<P>,
        ) -> impl Iterator<Item = u32> {
            phases
                .values()
                .flat_map(|phase| {
                    let multidrawable = phase.multidrawable_meshes.keys();
                    let batchable = phase.batchable_meshes.keys().map(|(key, _)| key);
                    let unbatchable = phase.unbatchable_meshes.keys().map(|(key, _)| key);
                    multidrawable.chain(batchable).chain(unbatchable)
                })
                .filter_map(|key| key.visibility_mask)
        }
        of(&self.extended_opaque)
            .chain(of(&self.extended_alpha_mask))
            .collect()
    }
}

impl GBufferPhases<'_> {
    fn prepare_for_new_frame(&mut self, view: RetainedViewEntity, mode: GpuPreprocessingMode) {
        self.opaque.prepare_for_new_frame(view, mode);
        self.alpha_mask.prepare_for_new_frame(view, mode);
        self.extended_opaque.prepare_for_new_frame(view, mode);
        self.extended_alpha_mask.prepare_for_new_frame(view, mode);
    }

    fn retain(&mut self, live: &[RetainedViewEntity]) {
        self.opaque.retain(|view, _| live.contains(view));
        self.alpha_mask.retain(|view, _| live.contains(view));
        self.extended_opaque.retain(|view, _| live.contains(view));
        self.extended_alpha_mask
            .retain(|view, _| live.contains(view));
    }

    /// The phases of `view`, if it has any in this frame.
    pub(super) fn of(&mut self, view: &RetainedViewEntity) -> Option<GBufferViewPhases<'_>> {
        Some(GBufferViewPhases {
            opaque: self.opaque.get_mut(view)?,
            alpha_mask: self.alpha_mask.get_mut(view)?,
            extended_opaque: self.extended_opaque.get_mut(view)?,
            extended_alpha_mask: self.extended_alpha_mask.get_mut(view)?,
        })
    }
}

/// The phases of one view.
pub(super) struct GBufferViewPhases<'a> {
    opaque: &'a mut BinnedRenderPhase<OpaqueGBuffer>,
    alpha_mask: &'a mut BinnedRenderPhase<AlphaMaskGBuffer>,
    extended_opaque: &'a mut BinnedRenderPhase<ExtendedOpaqueGBuffer>,
    extended_alpha_mask: &'a mut BinnedRenderPhase<ExtendedAlphaMaskGBuffer>,
}

impl GBufferViewPhases<'_> {
    /// Takes `mesh` out of whichever phase it is in.
    pub(super) fn remove(&mut self, mesh: MainEntity) {
        remove(self.opaque, mesh);
        remove(self.alpha_mask, mesh);
        remove(self.extended_opaque, mesh);
        remove(self.extended_alpha_mask, mesh);
    }

    /// Puts a mesh that is in none of the phases into one of them.
    pub(super) fn add(&mut self, alpha_masked: bool, extended: bool, item: QueuedMesh) {
        match (extended, alpha_masked) {
            (false, false) => item.add_to(self.opaque),
            (false, true) => item.add_to(self.alpha_mask),
            (true, false) => item.add_to(self.extended_opaque),
            (true, true) => item.add_to(self.extended_alpha_mask),
        }
    }
}

fn remove<P: BinnedPhaseItem>(phase: &mut BinnedRenderPhase<P>, mesh: MainEntity) {
    if !phase.is_empty() {
        phase.remove(mesh);
    }
}

/// What a phase must know to draw a mesh.
pub(super) struct QueuedMesh {
    /// With what it fills the target of that name, if it does.
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
    fn add_to<P>(self, phase: &mut BinnedRenderPhase<P>)
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

/// Keeps a phase of each kind for every active camera with [`LeanDeferred`], and none for others.
pub(super) fn extract_gbuffer_phases(
    mut phases: GBufferPhases,
    cameras: Extract<
        Query<(Entity, &Camera, Has<NoIndirectDrawing>), (With<Camera3d>, With<LeanDeferred>)>,
    >,
    gpu_preprocessing_support: Res<GpuPreprocessingSupport>,
    mut live: Local<Vec<RetainedViewEntity>>,
) {
    live.clear();
    for (camera_entity, camera, no_indirect_drawing) in &cameras {
        if !camera.is_active {
            continue;
        }
        let mode = gpu_preprocessing_support.min(if no_indirect_drawing {
            GpuPreprocessingMode::PreprocessingOnly
        } else {
            GpuPreprocessingMode::Culling
        });
        // A camera's own view is its subview 0.
        let view = RetainedViewEntity::new(camera_entity.into(), None, 0);
        phases.prepare_for_new_frame(view, mode);
        live.push(view);
    }
    phases.retain(&live);
}
