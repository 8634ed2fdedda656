//! Bevy's own phases of a lean view: what the G-buffer carries is taken out of them, and what it no longer carries is
//! put back, without Bevy having to specialize and queue it anew.

use bevy::{
    core_pipeline::{
        core_3d::{AlphaMask3d, Opaque3d, Opaque3dBatchSetKey, Opaque3dBinKey},
        deferred::{AlphaMask3dDeferred, Opaque3dDeferred},
        prepass::{
            AlphaMask3dPrepass, DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass,
            Opaque3dPrepass, OpaqueNoLightmap3dBatchSetKey, OpaqueNoLightmap3dBinKey,
        },
    },
    ecs::system::SystemParam,
    material::{OpaqueRendererMethod, RenderPhaseType},
    pbr::{
        MainPassAlphaMaskDrawFunction, MainPassOpaqueDrawFunction,
        PrepassOpaqueDepthOnlyDrawFunction, SpecializedMaterialPipelineCache,
        SpecializedMaterialViewPipelineCache, SpecializedPrepassMaterialPipelineCache,
        SpecializedPrepassMaterialViewPipelineCache,
    },
    prelude::*,
    render::{
        Extract,
        batching::gpu_preprocessing::{GpuPreprocessingMode, GpuPreprocessingSupport},
        render_phase::{
            BinnedPhaseItem, BinnedRenderPhase, BinnedRenderPhaseType, ViewBinnedRenderPhases,
        },
        sync_world::MainEntity,
        view::{NoIndirectDrawing, RetainedViewEntity},
    },
};

use super::lookup::MeshToQueue;
use crate::LeanDeferred;

/// The phases of all views.
#[derive(SystemParam)]
pub(super) struct BevyPhases<'w> {
    opaque: ResMut<'w, ViewBinnedRenderPhases<Opaque3d>>,
    alpha_mask: ResMut<'w, ViewBinnedRenderPhases<AlphaMask3d>>,
    opaque_prepass: ResMut<'w, ViewBinnedRenderPhases<Opaque3dPrepass>>,
    alpha_mask_prepass: ResMut<'w, ViewBinnedRenderPhases<AlphaMask3dPrepass>>,
    opaque_deferred: ResMut<'w, ViewBinnedRenderPhases<Opaque3dDeferred>>,
    alpha_mask_deferred: ResMut<'w, ViewBinnedRenderPhases<AlphaMask3dDeferred>>,
    pipelines: Res<'w, SpecializedMaterialPipelineCache>,
    prepass_pipelines: Res<'w, SpecializedPrepassMaterialPipelineCache>,
}

/// The phases of one view, as far as it has them.
pub(super) struct BevyViewPhases<'a> {
    opaque: Option<&'a mut BinnedRenderPhase<Opaque3d>>,
    alpha_mask: Option<&'a mut BinnedRenderPhase<AlphaMask3d>>,
    opaque_prepass: Option<&'a mut BinnedRenderPhase<Opaque3dPrepass>>,
    alpha_mask_prepass: Option<&'a mut BinnedRenderPhase<AlphaMask3dPrepass>>,
    opaque_deferred: Option<&'a mut BinnedRenderPhase<Opaque3dDeferred>>,
    alpha_mask_deferred: Option<&'a mut BinnedRenderPhase<AlphaMask3dDeferred>>,
    pipelines: Option<&'a SpecializedMaterialViewPipelineCache>,
    prepass_pipelines: Option<&'a SpecializedPrepassMaterialViewPipelineCache>,
}

impl BevyPhases<'_> {
    pub(super) fn of(&mut self, view: &RetainedViewEntity) -> BevyViewPhases<'_> {
        BevyViewPhases {
            opaque: self.opaque.get_mut(view),
            alpha_mask: self.alpha_mask.get_mut(view),
            opaque_prepass: self.opaque_prepass.get_mut(view),
            alpha_mask_prepass: self.alpha_mask_prepass.get_mut(view),
            opaque_deferred: self.opaque_deferred.get_mut(view),
            alpha_mask_deferred: self.alpha_mask_deferred.get_mut(view),
            pipelines: self.pipelines.get(view),
            prepass_pipelines: self.prepass_pipelines.get(view),
        }
    }
}

impl BevyViewPhases<'_> {
    /// Leaves the drawing of `mesh` to the G-buffer. It stays in the prepass if the G-buffer does not write all that the
    /// prepass does.
    pub(super) fn take_out(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        phase_type: BinnedRenderPhaseType,
        keeps_prepass: bool,
    ) {
        match mesh.material.properties.render_phase_type {
            RenderPhaseType::Opaque => {
                remove(&mut self.opaque, entity);
                if !keeps_prepass {
                    remove(&mut self.opaque_prepass, entity);
                }
            }
            RenderPhaseType::AlphaMask => {
                remove(&mut self.alpha_mask, entity);
                if !keeps_prepass {
                    remove(&mut self.alpha_mask_prepass, entity);
                }
            }
            _ => return,
        }
        if self.takes_from_deferred(entity, mesh) && keeps_prepass {
            self.put_into_prepass(entity, mesh, phase_type);
        }
    }

    /// Has the forward renderer draw a mesh that Bevy has just queued. Nothing is to be done, but for those whose method is
    /// `Deferred`: Bevy leaves them to its own deferred pass, which a lean view does not have.
    pub(super) fn leave_in(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        phase_type: BinnedRenderPhaseType,
    ) {
        if mesh.material.properties.render_method == OpaqueRendererMethod::Deferred {
            self.put_back(entity, mesh, phase_type);
        }
    }

    /// Has the forward renderer draw `mesh`, whoever drew it before.
    pub(super) fn put_back(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        phase_type: BinnedRenderPhaseType,
    ) {
        self.takes_from_deferred(entity, mesh);
        let properties = &mesh.material.properties;
        let Some(&pipeline) = self.pipelines.and_then(|pipelines| pipelines.get(&entity)) else {
            // Bevy waits for it, too, and queues it then.
            return;
        };
        let entities = (Entity::PLACEHOLDER, entity);
        let material_bind_group_index = Some(mesh.material.binding.group.0);
        let asset_id = mesh.instance.mesh_asset_id().into();
        let uniform_index = mesh.instance.current_uniform_index;
        match properties.render_phase_type {
            RenderPhaseType::Opaque => {
                remove(&mut self.opaque, entity);
                if let (Some(phase), Some(draw_function)) = (
                    &mut self.opaque,
                    properties.get_draw_function(MainPassOpaqueDrawFunction),
                ) {
                    let lightmap_slab = mesh.instance.lightmap_slab_index().map(|index| *index);
                    let key = Opaque3dBatchSetKey {
                        pipeline,
                        draw_function,
                        material_bind_group_index,
                        slabs: mesh.slabs,
                        lightmap_slab,
                    };
                    let bin = Opaque3dBinKey { asset_id };
                    phase.add(key, bin, entities, uniform_index, phase_type);
                }
            }
            RenderPhaseType::AlphaMask => {
                remove(&mut self.alpha_mask, entity);
                if let (Some(phase), Some(draw_function)) = (
                    &mut self.alpha_mask,
                    properties.get_draw_function(MainPassAlphaMaskDrawFunction),
                ) {
                    let key = OpaqueNoLightmap3dBatchSetKey {
                        pipeline,
                        draw_function,
                        material_bind_group_index,
                        slabs: mesh.slabs,
                    };
                    let bin = OpaqueNoLightmap3dBinKey { asset_id };
                    phase.add(key, bin, entities, uniform_index, phase_type);
                }
            }
            // These were never taken out.
            _ => return,
        }
        self.put_into_prepass(entity, mesh, phase_type);
    }

    /// On a view that has a prepass, but no deferred one, Bevy puts meshes whose method is `Deferred` into the deferred
    /// phase with the pipeline of the prepass: see [`extract_deferred_phases`]. Returns whether this is such a mesh.
    fn takes_from_deferred(&mut self, entity: MainEntity, mesh: &MeshToQueue) -> bool {
        if mesh.material.properties.render_method != OpaqueRendererMethod::Deferred {
            return false;
        }
        self.forget_deferred(entity);
        true
    }

    /// Nothing that a lean view draws may be left there.
    pub(super) fn forget_deferred(&mut self, entity: MainEntity) {
        remove(&mut self.opaque_deferred, entity);
        remove(&mut self.alpha_mask_deferred, entity);
    }

    /// As Bevy's `queue_prepass_material_meshes` does it for meshes whose method is `Forward`.
    fn put_into_prepass(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        phase_type: BinnedRenderPhaseType,
    ) {
        let Some(&(_, pipeline, draw_function)) = self
            .prepass_pipelines
            .and_then(|pipelines| pipelines.get(&entity))
        else {
            return;
        };
        let properties = &mesh.material.properties;
        let depth_only = properties.get_draw_function(PrepassOpaqueDepthOnlyDrawFunction);
        let reads_material = Some(draw_function) != depth_only;
        let is_opaque = matches!(properties.render_phase_type, RenderPhaseType::Opaque);
        let key = OpaqueNoLightmap3dBatchSetKey {
            pipeline,
            draw_function,
            material_bind_group_index: (reads_material || !is_opaque)
                .then_some(mesh.material.binding.group.0),
            slabs: mesh.slabs,
        };
        let bin = OpaqueNoLightmap3dBinKey {
            asset_id: mesh.instance.mesh_asset_id().into(),
        };
        let entities = (Entity::PLACEHOLDER, entity);
        let uniform_index = mesh.instance.current_uniform_index;
        if is_opaque {
            remove(&mut self.opaque_prepass, entity);
            if let Some(phase) = &mut self.opaque_prepass {
                phase.add(key, bin, entities, uniform_index, phase_type);
            }
        } else {
            remove(&mut self.alpha_mask_prepass, entity);
            if let Some(phase) = &mut self.alpha_mask_prepass {
                phase.add(key, bin, entities, uniform_index, phase_type);
            }
        }
    }
}

pub(super) fn remove<P: BinnedPhaseItem>(
    phase: &mut Option<&mut BinnedRenderPhase<P>>,
    mesh: MainEntity,
) {
    if let Some(phase) = phase {
        phase.remove(mesh);
    }
}

/// Gives lean cameras that have a prepass, but no deferred one, empty deferred phases. Bevy's
/// `queue_prepass_material_meshes` takes for granted that every view with a prepass has them as soon as a material's method
/// is `Deferred`, which all may be in an app that comes from Bevy's deferred renderer. The meshes are taken out again before
/// anything is drawn.
pub(super) fn extract_deferred_phases(
    mut opaque: ResMut<ViewBinnedRenderPhases<Opaque3dDeferred>>,
    mut alpha_mask: ResMut<ViewBinnedRenderPhases<AlphaMask3dDeferred>>,
    cameras: Extract<
        Query<
            (Entity, &Camera, Has<NoIndirectDrawing>),
            (
                With<Camera3d>,
                With<LeanDeferred>,
                Without<DeferredPrepass>,
                Or<(
                    With<DepthPrepass>,
                    With<NormalPrepass>,
                    With<MotionVectorPrepass>,
                )>,
            ),
        >,
    >,
    gpu_preprocessing_support: Res<GpuPreprocessingSupport>,
) {
    for (camera_entity, camera, no_indirect_drawing) in &cameras {
        if !camera.is_active {
            continue;
        }
        let mode = preprocessing_mode(&gpu_preprocessing_support, no_indirect_drawing);
        let view = RetainedViewEntity::new(camera_entity.into(), None, 0);
        opaque.prepare_for_new_frame(view, mode);
        alpha_mask.prepare_for_new_frame(view, mode);
    }
}

/// How Bevy prepares the draws of a camera's phases.
pub(super) fn preprocessing_mode(
    support: &GpuPreprocessingSupport,
    no_indirect_drawing: bool,
) -> GpuPreprocessingMode {
    support.min(if no_indirect_drawing {
        GpuPreprocessingMode::PreprocessingOnly
    } else {
        GpuPreprocessingMode::Culling
    })
}
