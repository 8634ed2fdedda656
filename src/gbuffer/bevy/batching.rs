//! Batching of the G-buffer's phases. Repeats the systems of Bevy's `BinnedRenderPhasePlugin`, which are in no set by which they could
//! be skipped.

use bevy::{
    pbr::{MeshInputUniform, MeshPipeline, MeshUniform},
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderSystems,
        batching::{
            gpu_preprocessing::{
                self, BatchedInstanceBuffers, PhaseBatchedInstanceBuffers,
                PhaseIndirectParametersBuffers,
            },
            no_gpu_preprocessing::{self, BatchedInstanceBuffer},
            sort_binned_render_phase,
        },
        render_phase::{
            AddRenderCommand, BinnedPhaseItem, CachedRenderPipelinePhaseItem, DrawFunctions,
            ViewBinnedRenderPhases,
        },
    },
};

use crate::{
    gbuffer::{draw_functions::DrawPlain, phase_item::GBufferBatchSetKey},
    view::EffectSystems,
};

type InstancesFromCpu = BatchedInstanceBuffer<MeshUniform>;
type InstancesFromGpu = BatchedInstanceBuffers<MeshUniform, MeshInputUniform>;

/// Adds a phase that is batched like Bevy's prepasses.
pub(in crate::gbuffer) fn add_phase<P>(app: &mut App)
where
    P: BinnedPhaseItem<BatchSetKey = GBufferBatchSetKey> + CachedRenderPipelinePhaseItem,
{
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
        return;
    };
    render_app
        .init_resource::<DrawFunctions<P>>()
        .add_render_command::<P, DrawPlain<false>>()
        .init_gpu_resource::<ViewBinnedRenderPhases<P>>()
        .allow_ambiguous_resource::<ViewBinnedRenderPhases<P>>()
        .init_gpu_resource::<PhaseBatchedInstanceBuffers<P, MeshUniform>>()
        .init_gpu_resource::<PhaseIndirectParametersBuffers<P>>()
        .add_systems(
            Render,
            (
                sort_binned_render_phase::<P>.in_set(RenderSystems::PhaseSort),
                (
                    no_gpu_preprocessing::batch_and_prepare_binned_render_phase::<P, MeshPipeline>
                        .run_if(resource_exists::<InstancesFromCpu>),
                    gpu_preprocessing::batch_and_prepare_binned_render_phase::<P, MeshPipeline>
                        .run_if(resource_exists::<InstancesFromGpu>),
                )
                    .in_set(RenderSystems::PrepareResourcesBatchPhases)
                    .ambiguous_with(RenderSystems::PrepareResourcesBatchPhases),
                gpu_preprocessing::write_binned_instance_buffers::<P, MeshPipeline>
                    .run_if(resource_exists::<InstancesFromGpu>)
                    .in_set(RenderSystems::PrepareResourcesWritePhaseBuffers)
                    .ambiguous_with(RenderSystems::PrepareResourcesWritePhaseBuffers),
                gpu_preprocessing::collect_buffers_for_phase::<P, MeshPipeline>
                    .run_if(resource_exists::<InstancesFromGpu>)
                    .in_set(RenderSystems::PrepareResourcesCollectPhaseBuffers),
            )
                .in_set(EffectSystems::Lean),
        );
}
