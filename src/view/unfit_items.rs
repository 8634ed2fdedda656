//! What other crates have left in Bevy's phases of a camera whose `Msaa` or `Hdr` was changed.
//!
//! Bevy takes its own meshes out of the phases of such a view and queues them anew. Items of others stay there with a pipeline for another
//! sample count or format, which ends the app when it is set, and with entities that may be gone, which their draw functions may not
//! expect. (`bevy_hanabi` 0.19 adds particles to `Opaque3d` in each frame, by a key that has the pipeline: under the old key the
//! particles of a frame before remain.)

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

/// What the passes of a view have their pipelines for.
#[derive(Clone, Copy)]
struct Attachments {
    samples: u32,
    format: TextureFormat,
}

impl Attachments {
    /// Of pipelines that are not known yet nothing is said.
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

/// Takes items out of the phases of views that changed in this frame whose pipeline does not fit the view any more. Before all queue
/// systems, which may add them again.
pub(super) fn drop_unfit_items(
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

/// Bevy puts nothing but meshes into these phases, and takes those out itself.
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
