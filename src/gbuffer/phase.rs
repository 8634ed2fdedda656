//! The two render phases of the G-buffer.

use core::ops::Range;

use bevy::{
    core_pipeline::prepass::{OpaqueNoLightmap3dBatchSetKey, OpaqueNoLightmap3dBinKey},
    prelude::*,
    render::{
        Extract,
        batching::gpu_preprocessing::{GpuPreprocessingMode, GpuPreprocessingSupport},
        render_phase::{
            BinnedPhaseItem, CachedRenderPipelinePhaseItem, DrawFunctionId, PhaseItem,
            PhaseItemExtraIndex, ViewBinnedRenderPhases,
        },
        render_resource::CachedRenderPipelineId,
        sync_world::MainEntity,
        view::{NoIndirectDrawing, RetainedViewEntity},
    },
};

use crate::LeanDeferred;

/// Declares a binned phase item keyed like Bevy's prepass and deferred phases.
macro_rules! gbuffer_phase {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        pub struct $name {
            /// What must be equal to be drawn by one multi-draw.
            pub batch_set_key: OpaqueNoLightmap3dBatchSetKey,
            /// What must be equal to be drawn as instances.
            pub bin_key: OpaqueNoLightmap3dBinKey,
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
                self.batch_set_key.draw_function
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
            type BatchSetKey = OpaqueNoLightmap3dBatchSetKey;
            type BinKey = OpaqueNoLightmap3dBinKey;

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

        impl CachedRenderPipelinePhaseItem for $name {
            fn cached_pipeline(&self) -> CachedRenderPipelineId {
                self.batch_set_key.pipeline
            }
        }
    };
}

gbuffer_phase! {
    /// Opaque meshes of the G-buffer.
    OpaqueGBuffer
}

gbuffer_phase! {
    /// Alpha-masked meshes of the G-buffer.
    AlphaMaskGBuffer
}

/// Keeps a phase of each kind for every active camera with [`LeanDeferred`], and none for others.
pub(super) fn extract_gbuffer_phases(
    mut opaque_phases: ResMut<ViewBinnedRenderPhases<OpaqueGBuffer>>,
    mut alpha_mask_phases: ResMut<ViewBinnedRenderPhases<AlphaMaskGBuffer>>,
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
        opaque_phases.prepare_for_new_frame(view, mode);
        alpha_mask_phases.prepare_for_new_frame(view, mode);
        live.push(view);
    }
    opaque_phases.retain(|view, _| live.contains(view));
    alpha_mask_phases.retain(|view, _| live.contains(view));
}
