//! Decides per camera and frame if occlusion is computed, and with which pipelines.

use core::iter;

use bevy::{
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{CachedRenderPipelineId, PipelineCache},
        view::ExtractedView,
    },
};

use super::{
    key::{GatherKey, MergeKey},
    pipelines::{GatherPipeline, OcclusionPipelines},
    settings::{LeanScreenSpaceAmbientOcclusion, OcclusionApplication},
};
use crate::{
    gpu::pipeline_watch::PipelineWatch,
    shader_library::reconstruction::position::projection_of,
    view::{
        ActiveLeanView, Effect, EffectStatuses, LeanDeferred, LeanOffReason, LeanResolution,
        LeanSupport, LightingIo, OccludesLight, OutOfMemory,
    },
};

/// On a view of the render world that has ambient occlusion this frame.
#[derive(Component, Clone, Copy, Debug)]
pub struct ActiveOcclusion {
    /// Settings used this frame: the camera's, or former ones while pipelines for the camera's compile.
    pub(super) settings: LeanScreenSpaceAmbientOcclusion,
    pub(super) key: GatherKey,
    /// `None` while lighting applies occlusion but no gather is compiled: nothing is occluded then.
    pub(super) gather: Option<GatherPipeline>,
    /// The merge pass; `None` if lighting applies the occlusion.
    pub(super) merge: Option<(MergeKey, CachedRenderPipelineId)>,
}

impl ActiveOcclusion {
    fn is_compiled(&self, cache: &PipelineCache) -> bool {
        self.gather.is_some_and(|gather| gather.is_compiled(cache))
            && self
                .merge
                .is_none_or(|(_, merge)| cache.get_render_pipeline(merge).is_some())
    }

    /// True if a gather of `key` is right for the view.
    fn is_covered_by(&self, key: GatherKey) -> bool {
        // Only occlusion for lighting is weighted about the G-buffer's normals.
        key.projection.covers(self.key.projection) && (self.merge.is_none() || !key.shading_normals)
    }

    /// Fallbacks for a frame in which `self` is not compiled: the gather of the `last` state, any other of `pipelines`, or all of the
    /// last state, where they are compatible.
    fn stand_ins(
        self,
        last: Option<Self>,
        pipelines: &OcclusionPipelines,
    ) -> impl Iterator<Item = Self> {
        let last = last.filter(|last| self.is_covered_by(last.key));
        let of_last = last.and_then(|last| Some((last.key, last.gather?)));
        let all = last.filter(|last| match (last.merge, self.merge) {
            (Some((last, _)), Some((own, _))) => last.target == own.target,
            _ => false,
        });
        // Shared depths are those of contiguous pixels.
        let is_half = self.settings.resolution == LeanResolution::Half;
        let gathers = of_last.into_iter().chain(pipelines.gathers());
        gathers
            .filter(move |(key, _)| self.is_covered_by(*key) && !(is_half && key.shares_depths))
            .map(move |(key, gather)| Self {
                key,
                gather: Some(gather),
                ..self
            })
            .chain(all)
    }
}

impl LeanScreenSpaceAmbientOcclusion {
    /// True if the lighting pass of a lean view applies the occlusion.
    fn is_for_lighting(&self) -> bool {
        self.application != OcclusionApplication::MultiplicativeBlend
    }
}

/// Asks the lighting of lean cameras to apply occlusion, unless it is to be blended: inserts or removes [`OccludesLight`]. Lighting
/// filters what is gathered, so it is asked for another filter once the gather for that is compiled.
pub(super) fn request_lighting(
    mut commands: Commands,
    support: Res<LeanSupport>,
    pipelines: Option<ResMut<OcclusionPipelines>>,
    (pipeline_cache, watch): (Res<PipelineCache>, Res<PipelineWatch>),
    views: Query<(
        Entity,
        &ExtractedView,
        &LeanScreenSpaceAmbientOcclusion,
        Has<LeanDeferred>,
        Option<&OccludesLight>,
    )>,
) {
    let Some(mut pipelines) = pipelines else {
        return;
    };
    let computes = support.ambient_occlusion_by_compute.is_ok();
    for (entity, view, settings, has_lighting, current) in &views {
        let is_asked = has_lighting && settings.is_for_lighting();
        let wanted = is_asked.then(|| OccludesLight(settings.lighting_io()));
        if wanted.as_ref() == current {
            continue;
        }
        match wanted {
            Some(wanted) => {
                let projection = projection_of(view.clip_from_view);
                let key = GatherKey::new(settings, true, computes, projection);
                let gather = pipelines.gather(&pipeline_cache, &watch, key);
                let is_compiled = gather.is_some_and(|gather| gather.is_compiled(&pipeline_cache));
                if current.is_none() || is_compiled {
                    commands.entity(entity).insert(wanted);
                }
            }
            None => {
                commands.entity(entity).remove::<OccludesLight>();
            }
        }
    }
}

/// Inserts or removes [`ActiveOcclusion`]. While pipelines for new settings compile, others stand in. Cameras that are
/// switched off lose it, which frees their GPU resources.
///
/// Runs after lighting is decided: it applies the occlusion if [`ActiveLeanView::io`] says so, in the way that is said there.
pub(super) fn decide_active_occlusion(
    mut commands: Commands,
    support: Res<LeanSupport>,
    pipelines: Option<ResMut<OcclusionPipelines>>,
    (pipeline_cache, watch): (Res<PipelineCache>, Res<PipelineWatch>),
    (memory, mut statuses): (Res<OutOfMemory>, ResMut<EffectStatuses>),
    mut views: Query<(
        Entity,
        (&ExtractedCamera, &ExtractedView, Has<Camera3d>),
        &Msaa,
        &LeanScreenSpaceAmbientOcclusion,
        Option<&ActiveLeanView>,
        Option<&mut ActiveOcclusion>,
    )>,
    switched_off: Query<Entity, (With<ActiveOcclusion>, Without<ExtractedView>)>,
) {
    for entity in &switched_off {
        commands.entity(entity).remove::<ActiveOcclusion>();
    }
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for (entity, (camera, view, is_3d), msaa, settings, active_lean, current) in &mut views {
        let io = active_lean.map(|lean| lean.io);
        let is_for_lighting = io.is_some() && settings.is_for_lighting();
        let is_replaced = io.is_some_and(LightingIo::replaces_occlusion);
        let reason = LeanOffReason::against_reading_depth(camera, is_3d, msaa)
            .or(is_replaced.then_some(LeanOffReason::ReplacedByGi));
        let camera = view.retained_view_entity.main_entity;
        let mut status = statuses.of(camera, Effect::AmbientOcclusion);
        if status.is_off_for(reason) || status.is_off_by_memory(memory.label(entity)) {
            if current.is_some() {
                commands.entity(entity).remove::<ActiveOcclusion>();
            }
            continue;
        }
        let mut settings = *settings;
        let projection = projection_of(view.clip_from_view);
        let computes = support.ambient_occlusion_by_compute.is_ok();
        let key_of = |settings: &LeanScreenSpaceAmbientOcclusion| {
            GatherKey::new(settings, is_for_lighting, computes, projection)
        };
        let asked = pipelines.gather(&pipeline_cache, &watch, key_of(&settings));
        // While that compiles, lighting applies occlusion by former settings, or none.
        let lit = io.filter(|io| is_for_lighting && io.contains(LightingIo::AMBIENT_OCCLUSION));
        if let Some(io) = lit {
            settings = settings.as_lit(io);
        }
        let key = key_of(&settings);
        // Lighting is asked for settings that are gathered, so those of former ones are compiled, or others stand in.
        let gather = pipelines.asked_gather(key);
        let mut is_withheld = false;
        let merge = if is_for_lighting {
            None
        } else {
            let key = MergeKey {
                target: view.target_format,
                filter: settings.lighting_io() & LightingIo::OCCLUSION_FILTER,
            };
            let merge = pipelines.merge(&pipeline_cache, &watch, key);
            is_withheld = merge.is_none();
            merge.map(|merge| (key, merge))
        };
        let wanted = ActiveOcclusion {
            settings,
            key,
            gather,
            merge,
        };
        let last = current.as_deref().copied();
        let active = if is_withheld {
            None
        } else if is_for_lighting && lit.is_none() {
            // Goes on to blend what it blended before.
            last.filter(|last| last.merge.is_some() && last.key.projection.covers(projection))
        } else {
            iter::once(wanted)
                .chain(wanted.stand_ins(last, &pipelines))
                .find(|active| active.is_compiled(&pipeline_cache))
                .or_else(|| {
                    is_for_lighting.then_some(ActiveOcclusion {
                        gather: None,
                        ..wanted
                    })
                })
        };
        let runs = active.is_some_and(|active| active.gather.is_some());
        let merge = merge.map(|(_, merge)| merge.id());
        let ids = asked
            .into_iter()
            .chain(gather)
            .flat_map(GatherPipeline::ids);
        status.set_running(runs, watch.failure(ids.chain(merge)));
        match (active, current) {
            (Some(active), Some(mut current)) => *current = active,
            (Some(active), None) => {
                commands.entity(entity).insert(active);
            }
            (None, Some(_)) => {
                commands.entity(entity).remove::<ActiveOcclusion>();
            }
            (None, None) => {}
        }
    }
}
