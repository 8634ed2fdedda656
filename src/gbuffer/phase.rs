//! The render phases of the G-buffer: opaque and alpha-masked meshes, each with and without optional targets.

use bevy::{
    ecs::system::SystemParam,
    platform::collections::HashSet,
    prelude::*,
    render::{
        Extract,
        batching::gpu_preprocessing::{GpuPreprocessingMode, GpuPreprocessingSupport},
        render_phase::{
            BinnedPhaseItem, BinnedRenderPhase, CachedRenderPipelinePhaseItem, TrackedRenderPass,
            ViewBinnedRenderPhases,
        },
        sync_world::MainEntity,
        view::{NoIndirectDrawing, RetainedViewEntity},
    },
};

use super::{
    bevy::queue_rules::is_extracted,
    masked::MaskedPipelines,
    phase_item::{GBufferBatchSetKey, GBufferItem, QueuedMesh},
};
use crate::{gpu::named::system_param, view::LeanDeferred};

system_param! {
    /// The opaque and alpha-masked phases of all views, for meshes with or without optional targets.
    struct PhasePair<'w, const EXTENDED: bool> {
        opaque: ResMut<'w, ViewBinnedRenderPhases<GBufferItem<false, EXTENDED>>>,
        alpha_masked: ResMut<'w, ViewBinnedRenderPhases<GBufferItem<true, EXTENDED>>>,
    }
}

impl<const EXTENDED: bool> PhasePair<'_, EXTENDED> {
    fn prepare_for_new_frame(&mut self, view: RetainedViewEntity, mode: GpuPreprocessingMode) {
        self.opaque.prepare_for_new_frame(view, mode);
        self.alpha_masked.prepare_for_new_frame(view, mode);
    }

    fn retain(&mut self, live: &[RetainedViewEntity]) {
        self.opaque.retain(|view, _| live.contains(view));
        self.alpha_masked.retain(|view, _| live.contains(view));
    }

    fn of(&mut self, view: &RetainedViewEntity) -> Option<ViewPhasePair<'_, EXTENDED>> {
        Some(ViewPhasePair {
            opaque: self.opaque.get_mut(view)?,
            alpha_masked: self.alpha_masked.get_mut(view)?,
        })
    }
}

/// The phases of all views.
#[derive(SystemParam)]
pub(super) struct GBufferPhases<'w> {
    base: PhasePair<'w, false>,
    extended: PhasePair<'w, true>,
}

impl GBufferPhases<'_> {
    /// The phases of `view`, if it has any in this frame.
    pub(super) fn of(&mut self, view: &RetainedViewEntity) -> Option<GBufferViewPhases<'_>> {
        Some(GBufferViewPhases {
            base: self.base.of(view)?,
            extended: self.extended.of(view)?,
        })
    }
}

struct ViewPhasePair<'a, const EXTENDED: bool> {
    opaque: &'a mut BinnedRenderPhase<GBufferItem<false, EXTENDED>>,
    alpha_masked: &'a mut BinnedRenderPhase<GBufferItem<true, EXTENDED>>,
}

impl<const EXTENDED: bool> ViewPhasePair<'_, EXTENDED> {
    fn remove(&mut self, mesh: MainEntity) {
        remove(self.opaque, mesh);
        remove(self.alpha_masked, mesh);
    }

    fn add(&mut self, alpha_masked: bool, item: QueuedMesh) {
        if alpha_masked {
            item.add_to(self.alpha_masked);
        } else {
            item.add_to(self.opaque);
        }
    }
}

/// The phases of one view.
pub(super) struct GBufferViewPhases<'a> {
    base: ViewPhasePair<'a, false>,
    extended: ViewPhasePair<'a, true>,
}

impl GBufferViewPhases<'_> {
    /// Removes `mesh` from its phase, if it is in any.
    pub(super) fn remove(&mut self, mesh: MainEntity) {
        self.base.remove(mesh);
        self.extended.remove(mesh);
    }

    /// Adds a mesh that is in none of the phases.
    pub(super) fn add(&mut self, alpha_masked: bool, extended: bool, item: QueuedMesh) {
        if extended {
            self.extended.add(alpha_masked, item);
        } else {
            self.base.add(alpha_masked, item);
        }
    }
}

fn remove<P: BinnedPhaseItem>(phase: &mut BinnedRenderPhase<P>, mesh: MainEntity) {
    if !phase.is_empty() {
        phase.remove(mesh);
    }
}

system_param! {
    /// Read-only [`PhasePair`], for drawing.
    pub(super) struct DrawnPhasePair<'w, const EXTENDED: bool> {
        opaque: Res<'w, ViewBinnedRenderPhases<GBufferItem<false, EXTENDED>>>,
        alpha_masked: Res<'w, ViewBinnedRenderPhases<GBufferItem<true, EXTENDED>>>,
    }
}

impl<const EXTENDED: bool> DrawnPhasePair<'_, EXTENDED> {
    /// The meshes of `view`.
    pub(super) fn of(
        &self,
        view: &RetainedViewEntity,
    ) -> (
        DrawnPhase<'_, GBufferItem<false, EXTENDED>>,
        DrawnPhase<'_, GBufferItem<true, EXTENDED>>,
    ) {
        (
            DrawnPhase::new(self.opaque.get(view)),
            DrawnPhase::new(self.alpha_masked.get(view)),
        )
    }
}

/// A phase of one view, for drawing. `None` if it has no mesh.
pub(super) struct DrawnPhase<'a, P: BinnedPhaseItem>(Option<&'a BinnedRenderPhase<P>>);

impl<'a, P: BinnedPhaseItem + CachedRenderPipelinePhaseItem> DrawnPhase<'a, P> {
    fn new(phase: Option<&'a BinnedRenderPhase<P>>) -> Self {
        Self(phase.filter(|phase| !phase.is_empty()))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_none()
    }

    pub(super) fn render<'w>(
        &self,
        pass: &mut TrackedRenderPass<'w>,
        world: &'w World,
        view: Entity,
    ) {
        if let Some(phase) = self.0
            && let Err(error) = phase.render(pass, world, view)
        {
            error_once!("drawing {}: {error:?}", core::any::type_name::<P>());
        }
    }
}

impl<const EXTENDED: bool> DrawnPhase<'_, GBufferItem<true, EXTENDED>> {
    /// As [`render`](Self::render), after the depth of those that are drawn in two parts.
    pub(super) fn render_depth_first<'w>(
        &self,
        pass: &mut TrackedRenderPass<'w>,
        world: &'w World,
        view: Entity,
    ) {
        let pipelines = world.resource::<MaskedPipelines>();
        pipelines.render(|| self.render(pass, world, view));
    }
}

/// The phases of all views, read-only, for drawing.
#[derive(SystemParam)]
pub(super) struct DrawnGBufferPhases<'w> {
    pub(super) base: DrawnPhasePair<'w, false>,
    pub(super) extended: DrawnPhasePair<'w, true>,
}

impl DrawnGBufferPhases<'_> {
    /// All visibility masks that queued meshes write.
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
        of(&self.extended.opaque)
            .chain(of(&self.extended.alpha_masked))
            .collect()
    }
}

/// Keeps a phase of each kind for every extracted camera with [`LeanDeferred`], and none for others: phases of a camera
/// that is not extracted are not notified of despawned meshes.
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
        if !is_extracted(camera) {
            continue;
        }
        let mode = gpu_preprocessing_support.min(if no_indirect_drawing {
            GpuPreprocessingMode::PreprocessingOnly
        } else {
            GpuPreprocessingMode::Culling
        });
        // A camera's own view is its subview 0.
        let view = RetainedViewEntity::new(camera_entity.into(), None, 0);
        phases.base.prepare_for_new_frame(view, mode);
        phases.extended.prepare_for_new_frame(view, mode);
        live.push(view);
    }
    phases.base.retain(&live);
    phases.extended.retain(&live);
}
