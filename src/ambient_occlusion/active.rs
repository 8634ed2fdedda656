//! Decides per camera and frame if occlusion is computed, and with which pipelines.

use bevy::{
    pbr::DistanceFog,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{CachedRenderPipelineId, PipelineCache},
        sync_world::MainEntity,
        view::ExtractedView,
    },
};

use super::{
    key::{GatherKey, MergeKey},
    pipelines::{GatherPipeline, OcclusionPipelines},
    settings::{LeanAmbientOcclusion, OcclusionApplication, OcclusionNormals},
};
use crate::{
    shader_library::reconstruction::position::projection_of,
    view::{
        ActiveLeanView, LeanDeferred, LeanOffReason, LeanSupport, LightingIo, OutOfMemory,
        warn_once::WarnOnce,
    },
};

/// On a view of the render world that has ambient occlusion this frame.
#[derive(Component, Clone, Copy, Debug)]
pub struct ActiveOcclusion {
    /// Settings used this frame: the camera's, or the last compiled ones while the camera's compile.
    pub(super) settings: LeanAmbientOcclusion,
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

    /// Fallbacks for a frame in which `self` is not compiled: the `last` state, where it is compatible.
    fn stand_ins(self, last: Option<Self>) -> impl Iterator<Item = Self> {
        // Only occlusion for lighting is weighted about the G-buffer's normals.
        let last = last.filter(|last| {
            last.key.projection.covers(self.key.projection)
                && (self.merge.is_none() || !last.key.reads_normals())
        });
        // Pipelines of lighting and merge are compiled for one resolution.
        let gather = last
            .filter(|last| last.key.divisor == self.key.divisor)
            .map(|last| Self {
                key: last.key,
                gather: last.gather,
                ..self
            });
        let all = last.filter(|last| match (last.merge, self.merge) {
            (Some((last, _)), Some((own, _))) => last.target == own.target,
            _ => false,
        });
        gather.into_iter().chain(all)
    }
}

impl LeanAmbientOcclusion {
    /// True if the lighting pass of a lean view applies the occlusion.
    pub(crate) fn is_for_lighting(&self) -> bool {
        self.application != OcclusionApplication::MultiplicativeBlend
    }
}

/// Inserts or removes [`ActiveOcclusion`]. A view keeps its pipelines until those for new settings are compiled. Cameras that are
/// switched off lose it, which frees their GPU resources.
pub(super) fn decide_active_occlusion(
    mut commands: Commands,
    support: Res<LeanSupport>,
    pipelines: Option<ResMut<OcclusionPipelines>>,
    pipeline_cache: Res<PipelineCache>,
    memory: Res<OutOfMemory>,
    mut warnings: Local<WarnOnce<LeanOffReason>>,
    mut views: Query<(
        Entity,
        (&ExtractedCamera, &ExtractedView, Has<Camera3d>),
        &Msaa,
        &LeanAmbientOcclusion,
        (Option<&LeanDeferred>, Option<&ActiveLeanView>),
        Has<DistanceFog>,
        Option<&mut ActiveOcclusion>,
    )>,
    cameras: Query<&MainEntity, With<LeanAmbientOcclusion>>,
    switched_off: Query<Entity, (With<ActiveOcclusion>, Without<ExtractedView>)>,
) {
    warnings.keep_only(cameras.iter());
    for entity in &switched_off {
        commands.entity(entity).remove::<ActiveOcclusion>();
    }
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for (entity, (camera, view, is_3d), msaa, settings, (lean, active_lean), has_fog, current) in
        &mut views
    {
        let reason = LeanOffReason::against_reading_depth(camera, is_3d, msaa);
        let is_off = reason.is_some() || memory.label(entity).is_some();
        let camera = view.retained_view_entity.main_entity;
        warnings.tell("LeanAmbientOcclusion", camera, reason);
        let is_for_lighting = active_lean.is_some() && settings.is_for_lighting();
        // Diffuse GI also outputs visibility, so occlusion is skipped.
        let is_found =
            active_lean.is_some_and(|lean| lean.io.contains(LightingIo::INDIRECT_DIFFUSE));
        let shows_channel = lean.is_some_and(LeanDeferred::shows_channel);
        if is_off || is_found || (is_for_lighting && shows_channel) {
            if current.is_some() {
                commands.entity(entity).remove::<ActiveOcclusion>();
            }
            continue;
        }
        let key = GatherKey {
            kernel: settings.kernel,
            quality: settings.quality,
            // After the opaque meshes, the G-buffer's normals may be of surfaces that forward meshes have covered.
            shading_normals: is_for_lighting && settings.normals == OcclusionNormals::Shading,
            thin: settings.thickness < 1.0,
            wide: settings.has_wide_pattern(),
            divisor: settings.resolution.divisor(),
            projection: projection_of(view.clip_from_view),
        };
        let merge = (!is_for_lighting).then(|| {
            let key = MergeKey {
                target: view.target_format,
                filter: settings.into(),
                fog: has_fog,
                debug_view: settings.debug_view,
            };
            (key, pipelines.merge(&pipeline_cache, key))
        });
        let computes = support.ambient_occlusion_by_compute.is_ok();
        let gather = pipelines.gather(&pipeline_cache, key, computes);
        let wanted = ActiveOcclusion {
            settings: *settings,
            key,
            gather: Some(gather),
            merge,
        };
        let active = core::iter::once(wanted)
            .chain(wanted.stand_ins(current.as_deref().copied()))
            .find(|active| active.is_compiled(&pipeline_cache))
            .or_else(|| {
                is_for_lighting.then_some(ActiveOcclusion {
                    gather: None,
                    ..wanted
                })
            });
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
