//! Changes the pipelines with which Bevy's passes draw meshes of lean views. Phase, order and blending stay Bevy's.

use bevy::{
    core_pipeline::core_3d::Transparent3d,
    material::RenderPhaseType,
    pbr::{MainPassTransparentDrawFunction, SpecializedMaterialPipelineCache},
    prelude::*,
    render::{
        batching::gpu_preprocessing::GpuPreprocessingSupport,
        render_phase::{BinnedRenderPhaseType, DrawFunctionId, ViewSortedRenderPhases},
        render_resource::CachedRenderPipelineId,
        sync_world::MainEntity,
        view::{RenderVisibleEntitiesClass, RetainedViewEntity},
    },
};

use super::{phases::BevyPhases, queue_rules::visible_pair};
use crate::{
    gbuffer::{
        forward_meshes::ForwardMeshes,
        lookup::{MeshLookup, RecentKinds},
    },
    gpu::named::system_param,
};

/// Draw functions in place of Bevy's, for each phase.
#[derive(Clone, Copy)]
pub(crate) struct ForwardDrawFunctions {
    pub(crate) opaque: DrawFunctionId,
    pub(crate) alpha_mask: DrawFunctionId,
    pub(crate) transparent: DrawFunctionId,
}

/// A mesh that Bevy's passes draw otherwise from now on.
pub(crate) struct ForwardDraw {
    pub(crate) mesh: MainEntity,
    pub(crate) pipeline: CachedRenderPipelineId,
    /// `None` for Bevy's.
    pub(crate) draw_functions: Option<ForwardDrawFunctions>,
}

system_param! {
    /// The meshes in Bevy's phases. Its methods are to be called after `restore_pipelines`.
    pub(crate) struct ForwardDraws<'w> {
        lookup: MeshLookup<'w>,
        phases: BevyPhases<'w>,
        transparent: ResMut<'w, ViewSortedRenderPhases<Transparent3d>>,
        pipelines: Res<'w, SpecializedMaterialPipelineCache>,
        gpu_preprocessing: Res<'w, GpuPreprocessingSupport>,
        reports: ResMut<'w, ForwardMeshes>,
    }
}

impl ForwardDraws<'_> {
    /// Bevy's pipeline of a mesh. `None` if it is not among the `visible`, or not ready.
    pub(crate) fn bevys_pipeline(
        &self,
        view: &RetainedViewEntity,
        visible: &RenderVisibleEntitiesClass,
        mesh: MainEntity,
    ) -> Option<CachedRenderPipelineId> {
        visible_pair(visible, mesh)?;
        self.pipelines.get(view)?.get(&mesh).copied()
    }

    /// The layers of a mesh.
    pub(crate) fn visibility_mask(&self, mesh: MainEntity) -> u32 {
        self.lookup.special_meshes.visibility_mask(mesh)
    }

    /// Changes how Bevy's passes draw these meshes of a view. Those with specular transmission stay as they are.
    pub(crate) fn change(&mut self, view: &RetainedViewEntity, draws: &[ForwardDraw]) {
        if draws.is_empty() {
            return;
        }
        let mut kinds = RecentKinds::default();
        let mut phases = self.phases.of(view);
        let mut transparent = self.transparent.get_mut(view);
        for draw in draws {
            let Ok(found) = self.lookup.find(draw.mesh, &mut kinds) else {
                continue;
            };
            let properties = &found.material.properties;
            match properties.render_phase_type {
                RenderPhaseType::Transmissive => {}
                RenderPhaseType::Transparent => {
                    let key = (Entity::PLACEHOLDER, draw.mesh);
                    let phase = transparent.as_deref_mut();
                    let draw_function = (draw.draw_functions.map(|new| new.transparent))
                        .or_else(|| properties.get_draw_function(MainPassTransparentDrawFunction));
                    if let (Some(item), Some(draw_function)) = (
                        phase.and_then(|phase| phase.items.get_mut(&key)),
                        draw_function,
                    ) {
                        item.pipeline = draw.pipeline;
                        item.draw_function = draw_function;
                    }
                }
                RenderPhaseType::Opaque | RenderPhaseType::AlphaMask => {
                    let phase_type = BinnedRenderPhaseType::mesh(
                        found.instance.should_batch(),
                        &self.gpu_preprocessing,
                    );
                    phases.put_into_main(
                        draw.mesh,
                        &found,
                        phase_type,
                        draw.pipeline,
                        draw.draw_functions,
                    );
                }
            }
        }
    }

    /// Reports on the view's camera if the crate's light functions light `mesh`.
    pub(crate) fn report(&mut self, view: &RetainedViewEntity, mesh: MainEntity, is_lit: bool) {
        self.reports.set_lit(view.main_entity, mesh, is_lit);
    }
}
