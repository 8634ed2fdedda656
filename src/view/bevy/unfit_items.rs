//! Drops items of other crates from Bevy's phases of a camera whose `Msaa` or `Hdr` has changed.
//!
//! Bevy removes its own meshes from the phases of such a view and queues them again. Items of other crates stay, with a
//! pipeline for another sample count or format, which ends the app when it is set. Their entities may be despawned,
//! which their draw functions may not expect. (`bevy_hanabi` 0.19 adds particles to `Opaque3d` in each frame, with a
//! key that includes the pipeline: particles of an earlier frame stay under the old key.)

use bevy::{
    core_pipeline::core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
    pbr::Transmissive3d,
    prelude::*,
    render::{
        camera::DirtySpecializations,
        render_phase::{
            BinnedPhaseItem, CachedRenderPipelinePhaseItem, SortedPhaseItem,
            ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
        render_resource::{
            CachedRenderPipelineId, PipelineCache, PipelineDescriptor, TextureFormat,
        },
        view::{ExtractedView, RetainedViewEntity},
    },
};

/// Sample count and format of a view's attachments, which pipelines must match.
#[derive(Clone, Copy)]
struct Attachments {
    samples: u32,
    format: TextureFormat,
}

impl Attachments {
    /// True if the pipeline matches, or is not known yet.
    fn fit(self, pipeline: CachedRenderPipelineId, cache: &PipelineCache) -> bool {
        let descriptor = cache.pipelines().nth(pipeline.id());
        let Some(PipelineDescriptor::RenderPipelineDescriptor(descriptor)) =
            descriptor.map(|pipeline| &pipeline.descriptor)
        else {
            return true;
        };
        let targets = descriptor.fragment.iter().flat_map(|state| &state.targets);
        let target = targets.flatten().next();
        descriptor.multisample.count == self.samples
            && target.is_none_or(|target| target.format == self.format)
    }
}

/// Removes items whose pipeline no longer matches their view from the phases of views that changed in this frame. Runs
/// before all queue systems, which may add them again.
pub(in crate::view) fn drop_unfit_items(
    cache: Res<PipelineCache>,
    dirty: Res<DirtySpecializations>,
    (mut opaque, mut alpha_mask): (
        ResMut<ViewBinnedRenderPhases<Opaque3d>>,
        ResMut<ViewBinnedRenderPhases<AlphaMask3d>>,
    ),
    (mut transparent, mut transmissive): (
        ResMut<ViewSortedRenderPhases<Transparent3d>>,
        Option<ResMut<ViewSortedRenderPhases<Transmissive3d>>>,
    ),
    views: Query<(&ExtractedView, &Msaa)>,
) {
    if dirty.views.is_empty() {
        return;
    }
    for (view, msaa) in &views {
        let retained = view.retained_view_entity;
        if !dirty.must_wipe_specializations_for_view(retained) {
            continue;
        }
        let attachments = Attachments {
            samples: msaa.samples(),
            format: view.target_format,
        };
        let fits = |pipeline| attachments.fit(pipeline, &cache);
        drop_non_meshes(&mut opaque, &retained, |key| fits(key.pipeline));
        drop_non_meshes(&mut alpha_mask, &retained, |key| fits(key.pipeline));
        drop_sorted(&mut transparent, &retained, fits);
        if let Some(transmissive) = &mut transmissive {
            drop_sorted(transmissive, &retained, fits);
        }
    }
}

/// Drops only non-mesh items: Bevy adds none to these phases, and removes its meshes itself.
fn drop_non_meshes<P: BinnedPhaseItem>(
    phases: &mut ViewBinnedRenderPhases<P>,
    view: &RetainedViewEntity,
    fits: impl Fn(&P::BatchSetKey) -> bool,
) {
    if let Some(phase) = phases.get_mut(view) {
        phase.non_mesh_items.retain(|(key, _), _| fits(key));
    }
}

fn drop_sorted<P: SortedPhaseItem + CachedRenderPipelinePhaseItem>(
    phases: &mut ViewSortedRenderPhases<P>,
    view: &RetainedViewEntity,
    fits: impl Fn(CachedRenderPipelineId) -> bool,
) {
    if let Some(phase) = phases.get_mut(view) {
        phase.items.retain(|_, item| fits(item.cached_pipeline()));
    }
}
