//! Edits Bevy's own phases of a lean view: removes meshes that the G-buffer now draws and returns those that it no
//! longer draws. Bevy need not specialize and queue them again.

use bevy::{
    core_pipeline::{
        core_3d::{AlphaMask3d, Opaque3d, Opaque3dBatchSetKey, Opaque3dBinKey, Transparent3d},
        deferred::Opaque3dDeferred,
        prepass::{
            AlphaMask3dPrepass, Opaque3dPrepass, OpaqueNoLightmap3dBatchSetKey,
            OpaqueNoLightmap3dBinKey,
        },
    },
    material::RenderPhaseType,
    pbr::{
        MainPassAlphaMaskDrawFunction, MainPassOpaqueDrawFunction,
        PrepassOpaqueDepthOnlyDrawFunction, SpecializedPrepassMaterialViewPipelineCache,
        Transmissive3d,
    },
    prelude::*,
    render::{
        Extract,
        render_phase::{
            BinnedPhaseItem, BinnedRenderPhase, BinnedRenderPhaseType, ViewBinnedRenderPhases,
            ViewSortedRenderPhases,
        },
        render_resource::CachedRenderPipelineId,
        sync_world::MainEntity,
        view::RetainedViewEntity,
    },
};

use super::{forward_draws::ForwardDrawFunctions, queue_rules::is_extracted};
use crate::{gbuffer::lookup::MeshToQueue, gpu::named::system_param, view::LeanDeferred};

system_param! {
    /// The phases of all views.
    pub(in crate::gbuffer) struct BevyPhases<'w> {
        opaque: ResMut<'w, ViewBinnedRenderPhases<Opaque3d>>,
        alpha_mask: ResMut<'w, ViewBinnedRenderPhases<AlphaMask3d>>,
        opaque_prepass: ResMut<'w, ViewBinnedRenderPhases<Opaque3dPrepass>>,
        alpha_mask_prepass: ResMut<'w, ViewBinnedRenderPhases<AlphaMask3dPrepass>>,
        opaque_deferred: Res<'w, ViewBinnedRenderPhases<Opaque3dDeferred>>,
    }
}

/// The phases of one view; `None` for those that it lacks.
pub(in crate::gbuffer) struct BevyViewPhases<'a> {
    opaque: Option<&'a mut BinnedRenderPhase<Opaque3d>>,
    alpha_mask: Option<&'a mut BinnedRenderPhase<AlphaMask3d>>,
    opaque_prepass: Option<&'a mut BinnedRenderPhase<Opaque3dPrepass>>,
    alpha_mask_prepass: Option<&'a mut BinnedRenderPhase<AlphaMask3dPrepass>>,
}

impl BevyPhases<'_> {
    /// True if Bevy's deferred pass draws into the view.
    pub(in crate::gbuffer) fn draws_deferred(&self, view: &RetainedViewEntity) -> bool {
        self.opaque_deferred.contains_key(view)
    }

    pub(in crate::gbuffer) fn of(&mut self, view: &RetainedViewEntity) -> BevyViewPhases<'_> {
        BevyViewPhases {
            opaque: self.opaque.get_mut(view),
            alpha_mask: self.alpha_mask.get_mut(view),
            opaque_prepass: self.opaque_prepass.get_mut(view),
            alpha_mask_prepass: self.alpha_mask_prepass.get_mut(view),
        }
    }
}

impl BevyViewPhases<'_> {
    /// Removes a mesh that the G-buffer draws. It stays in the prepass if the G-buffer does not write everything that
    /// the prepass writes.
    pub(in crate::gbuffer) fn take_out(&mut self, mesh: MainEntity, keeps_prepass: bool) {
        remove(&mut self.opaque, mesh);
        remove(&mut self.alpha_mask, mesh);
        if !keeps_prepass {
            remove(&mut self.opaque_prepass, mesh);
            remove(&mut self.alpha_mask_prepass, mesh);
        }
    }

    /// Queues `mesh` for the forward renderer in place of any earlier entry, with draw functions in place of Bevy's if there are
    /// any. Mirrors Bevy's `queue_material_meshes` for opaque and alpha-masked meshes whose method is `Forward`.
    pub(in crate::gbuffer) fn put_into_main(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        phase_type: BinnedRenderPhaseType,
        pipeline: CachedRenderPipelineId,
        draw_functions: Option<ForwardDrawFunctions>,
    ) {
        let properties = &mesh.material.properties;
        let entities = (Entity::PLACEHOLDER, entity);
        let material_bind_group_index = Some(mesh.material.binding.group.0);
        let asset_id = mesh.instance.mesh_asset_id().into();
        let uniform_index = mesh.instance.current_uniform_index;
        match properties.render_phase_type {
            RenderPhaseType::Opaque => {
                remove(&mut self.opaque, entity);
                if let (Some(phase), Some(draw_function)) = (
                    &mut self.opaque,
                    (draw_functions.map(|functions| functions.opaque))
                        .or_else(|| properties.get_draw_function(MainPassOpaqueDrawFunction)),
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
                    (draw_functions.map(|functions| functions.alpha_mask))
                        .or_else(|| properties.get_draw_function(MainPassAlphaMaskDrawFunction)),
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
            // `take_out` never removes these.
            RenderPhaseType::Transmissive | RenderPhaseType::Transparent => {}
        }
    }

    /// Mirrors Bevy's `queue_prepass_material_meshes` for meshes whose method is `Forward`.
    pub(in crate::gbuffer) fn put_into_prepass(
        &mut self,
        entity: MainEntity,
        mesh: &MeshToQueue,
        phase_type: BinnedRenderPhaseType,
        pipelines: &SpecializedPrepassMaterialViewPipelineCache,
    ) {
        let Some(&(_, pipeline, draw_function)) = pipelines.get(&entity) else {
            return;
        };
        let properties = &mesh.material.properties;
        let is_opaque = match properties.render_phase_type {
            RenderPhaseType::Opaque => true,
            RenderPhaseType::AlphaMask => false,
            RenderPhaseType::Transmissive | RenderPhaseType::Transparent => return,
        };
        let depth_only = properties.get_draw_function(PrepassOpaqueDepthOnlyDrawFunction);
        let reads_material = Some(draw_function) != depth_only;
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

/// Drops the phases of lean cameras that are not extracted; runs after Bevy's systems that keep phases for all active
/// cameras. Bevy 0.19 keeps these phases (bevy#25649): meshes despawned meanwhile stay in them, and the others are
/// added a second time.
pub(in crate::gbuffer) fn drop_phases_of_views_without_pixels(
    mut binned: BevyPhases,
    mut transmissive: Option<ResMut<ViewSortedRenderPhases<Transmissive3d>>>,
    mut transparent: ResMut<ViewSortedRenderPhases<Transparent3d>>,
    cameras: Extract<Query<(Entity, &Camera), With<LeanDeferred>>>,
) {
    for (entity, camera) in &cameras {
        if camera.is_active && !is_extracted(camera) {
            let view = RetainedViewEntity::new(entity.into(), None, 0);
            binned.opaque.remove(&view);
            binned.alpha_mask.remove(&view);
            binned.opaque_prepass.remove(&view);
            binned.alpha_mask_prepass.remove(&view);
            if let Some(transmissive) = &mut transmissive {
                transmissive.remove(&view);
            }
            transparent.remove(&view);
        }
    }
}

fn remove<P: BinnedPhaseItem>(phase: &mut Option<&mut BinnedRenderPhase<P>>, mesh: MainEntity) {
    if let Some(phase) = phase {
        phase.remove(mesh);
    }
}
