//! Replaces the pipelines of meshes that Bevy has queued for its passes of lean views.

use bevy::{
    core_pipeline::core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
    mesh::Mesh3d,
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_phase::DrawFunctions,
        render_resource::{CachedRenderPipelineId, PipelineCache},
        sync_world::{MainEntity, MainEntityHashMap, MainEntityHashSet},
        view::{
            ExtractedView, RenderVisibleEntities, RenderVisibleEntitiesClass, RetainedViewEntity,
        },
    },
};

use super::{
    own_group::DrawWithOwnGroup,
    pipelines::{ForwardPipelines, OwnPipeline, Variant},
    reflections::ForwardReflections,
};
use crate::{
    gbuffer::{ForwardDraw, ForwardDrawFunctions, ForwardDraws, LeftMeshes},
    gpu::{named::system_param, pipeline_watch::PipelineWatch},
    view::{ActiveLeanView, LeanDeferred},
};

system_param! {
    /// The draw functions of meshes with a bind group of the crate's own.
    pub(super) struct OwnDrawFunctions<'w, 's> {
        opaque: Res<'w, DrawFunctions<Opaque3d>>,
        alpha_mask: Res<'w, DrawFunctions<AlphaMask3d>>,
        transparent: Res<'w, DrawFunctions<Transparent3d>>,
        /// Of the group of layers, and of that of reflections.
        ids: Local<'s, Option<[ForwardDrawFunctions; 2]>>,
    }
}

impl OwnDrawFunctions<'_, '_> {
    fn ids(&mut self, reflects: bool) -> ForwardDrawFunctions {
        let ids = *self.ids.get_or_insert_with(|| {
            let (opaque, alpha_mask, transparent) = (
                self.opaque.read(),
                self.alpha_mask.read(),
                self.transparent.read(),
            );
            [
                ForwardDrawFunctions {
                    opaque: opaque.id::<DrawWithOwnGroup<false>>(),
                    alpha_mask: alpha_mask.id::<DrawWithOwnGroup<false>>(),
                    transparent: transparent.id::<DrawWithOwnGroup<false>>(),
                },
                ForwardDrawFunctions {
                    opaque: opaque.id::<DrawWithOwnGroup<true>>(),
                    alpha_mask: alpha_mask.id::<DrawWithOwnGroup<true>>(),
                    transparent: transparent.id::<DrawWithOwnGroup<true>>(),
                },
            ]
        });
        ids[usize::from(reflects)]
    }
}

/// The meshes that Bevy's passes draw on one view.
#[derive(Default)]
pub(super) struct ForwardView {
    /// Each with true if a pipeline of the crate draws it.
    meshes: MainEntityHashMap<bool>,
    /// Meshes whose pipeline of Bevy's is not known yet, or whose own is withheld.
    waiting: Vec<MainEntity>,
    mode: Mode,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Mode {
    is_lit: bool,
    reads_layers: bool,
    reflects: bool,
}

/// Chooses the pipelines of meshes that views have left to Bevy in this frame. In frames in which a pipeline was compiled or a
/// view has changed, those of all such meshes.
pub(super) fn light_forward_meshes(
    mut draws: ForwardDraws,
    mut draw_functions: OwnDrawFunctions,
    mut pipelines: ResMut<ForwardPipelines>,
    (left, cache, watch): (Res<LeftMeshes>, Res<PipelineCache>, Res<PipelineWatch>),
    views: Query<(
        &ExtractedView,
        &RenderVisibleEntities,
        &LeanDeferred,
        Option<&ActiveLeanView>,
        Has<ForwardReflections>,
    )>,
    mut forward_views: Local<HashMap<RetainedViewEntity, ForwardView>>,
    mut changes: Local<Vec<ForwardDraw>>,
    mut looked_at: Local<Vec<(MainEntity, bool)>>,
) {
    if cache.is_added() {
        // Pipelines of another device.
        forward_views.clear();
    }
    let pipelines_have_changed = pipelines.update(&cache);
    forward_views.retain(|view, _| {
        let mut views = views.iter();
        views.any(|(other, ..)| other.retained_view_entity == *view)
    });
    for (view, visible, settings, active, reflects) in &views {
        let retained = view.retained_view_entity;
        let Some(visible) = visible.get::<Mesh3d>() else {
            continue;
        };
        let forward = forward_views.entry(retained).or_default();
        looked_at.clear();
        changes.clear();
        let Some(active) = active else {
            // Bevy draws the whole view.
            let lit = forward.meshes.drain().filter(|(_, is_lit)| *is_lit);
            looked_at.extend(lit);
            *forward = default();
            for &(mesh, _) in &*looked_at {
                if let Some(pipeline) = draws.bevys_pipeline(&retained, visible, mesh) {
                    changes.push(ForwardDraw {
                        mesh,
                        pipeline,
                        draw_functions: None,
                    });
                }
            }
            draws.change(&retained, &changes);
            continue;
        };
        let has_group = pipelines.layouts.is_some();
        if reflects && !has_group {
            warn_once!(
                "forward meshes do not reflect the image (`LeanScreenSpaceReflectionsAdvanced::forward_meshes`): the device has four bind \
                 groups of five; environment maps and ambient light remain"
            );
        }
        let mode = Mode {
            is_lit: settings.advanced.lights_forward_meshes,
            reads_layers: active.has_light_layers && has_group,
            reflects: reflects && has_group,
        };
        let looks_at_all =
            core::mem::replace(&mut forward.mode, mode) != mode || pipelines_have_changed;
        forward.follow(&left, &retained, looks_at_all, &mut looked_at);
        for &(mesh, was_lit) in &*looked_at {
            let found = forward.pipeline(
                &draws,
                &mut pipelines,
                (&cache, &watch),
                (&retained, visible),
                mesh,
            );
            let Some((bevys, own)) = found else {
                continue;
            };
            draws.report(&retained, mesh, own.is_some());
            if own.is_some() || was_lit {
                let with_group = own.filter(|own| mode.reads_layers || own.reflects);
                changes.push(ForwardDraw {
                    mesh,
                    pipeline: own.map_or(bevys, |own| own.id),
                    draw_functions: with_group.map(|own| draw_functions.ids(own.reflects)),
                });
            }
        }
        draws.change(&retained, &changes);
    }
}

impl ForwardView {
    /// Applies the changes of this frame, and lists the meshes to look at, each with true if a pipeline of the crate has drawn it.
    fn follow(
        &mut self,
        left: &LeftMeshes,
        view: &RetainedViewEntity,
        looks_at_all: bool,
        looked_at: &mut Vec<(MainEntity, bool)>,
    ) {
        let waiting = core::mem::take(&mut self.waiting);
        let mut formerly_lit = MainEntityHashSet::default();
        if let Some(changes) = left.get(view) {
            for mesh in &changes.removed {
                if self.meshes.remove(mesh) == Some(true) {
                    formerly_lit.insert(*mesh);
                }
            }
            for mesh in &changes.left {
                let was_lit = formerly_lit.contains(mesh);
                self.meshes.insert(*mesh, was_lit);
                looked_at.push((*mesh, was_lit));
            }
        }
        if looks_at_all {
            looked_at.clear();
            looked_at.extend(self.meshes.iter().map(|(mesh, was_lit)| (*mesh, *was_lit)));
        } else {
            for mesh in waiting {
                if let Some(was_lit) = self.meshes.get(&mesh) {
                    looked_at.push((mesh, *was_lit));
                }
            }
        }
    }

    /// Bevy's pipeline of a mesh, and the crate's that is to draw it, if one is. `None` if the mesh is not drawn.
    fn pipeline(
        &mut self,
        draws: &ForwardDraws,
        pipelines: &mut ForwardPipelines,
        cache_and_watch: (&PipelineCache, &PipelineWatch),
        (view, visible): (&RetainedViewEntity, &RenderVisibleEntitiesClass),
        mesh: MainEntity,
    ) -> Option<(CachedRenderPipelineId, Option<OwnPipeline>)> {
        let Some(bevys) = draws.bevys_pipeline(view, visible, mesh) else {
            self.meshes.remove(&mesh);
            return None;
        };
        let mut own = None;
        if self.mode.is_lit {
            let wanted = Variant {
                bevys,
                layers: (self.mode.reads_layers).then(|| draws.visibility_mask(mesh)),
                reflects: self.mode.reflects,
            };
            let choice = pipelines.choose(cache_and_watch, wanted);
            if !choice.is_known {
                self.waiting.push(mesh);
            }
            own = choice.own;
        }
        self.meshes.insert(mesh, own.is_some());
        Some((bevys, own))
    }
}
