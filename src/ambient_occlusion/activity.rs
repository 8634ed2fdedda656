//! Per camera and frame: whether and how occlusion is found and applied.

use bevy::{
    pbr::DistanceFog,
    prelude::*,
    render::{
        render_resource::{CachedComputePipelineId, CachedRenderPipelineId, PipelineCache},
        sync_world::MainEntity,
        view::ExtractedView,
    },
};

use super::{
    LeanAmbientOcclusion, OcclusionApplication, OcclusionNormals,
    pipelines::{GatherKey, MergeKey, OcclusionPipelines},
    support::OcclusionSupport,
    uniforms::projection_of,
};
use crate::{camera::ActiveLeanView, warn_once::WarnOnce};

/// On a view of the render world: this frame it has ambient occlusion.
#[derive(Component, Clone, Copy, Debug)]
pub struct ActiveOcclusion {
    pub(super) key: GatherKey,
    pub(super) gather: GatherPipeline,
    /// The merge pass; `None` if lighting applies the occlusion.
    pub(super) merge: Option<CachedRenderPipelineId>,
}

/// How occlusion is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GatherPipeline {
    Compute(CachedComputePipelineId),
    Raster(CachedRenderPipelineId),
}

impl LeanAmbientOcclusion {
    /// Whether the lighting pass of a lean view is to apply it.
    pub(crate) fn is_for_lighting(&self) -> bool {
        self.application != OcclusionApplication::MultiplicativeBlend
    }
}

/// Why cameras are without.
#[derive(Resource)]
pub(super) struct Warnings(WarnOnce<&'static str>);

impl Default for Warnings {
    fn default() -> Self {
        Self(WarnOnce::new("LeanAmbientOcclusion"))
    }
}

/// Inserts or removes [`ActiveOcclusion`].
pub(super) fn decide_active_occlusion(
    mut commands: Commands,
    support: Option<Res<OcclusionSupport>>,
    pipelines: Option<ResMut<OcclusionPipelines>>,
    pipeline_cache: Res<PipelineCache>,
    mut warnings: ResMut<Warnings>,
    views: Query<(
        Entity,
        &ExtractedView,
        &Msaa,
        &LeanAmbientOcclusion,
        Option<&ActiveLeanView>,
        Has<DistanceFog>,
    )>,
    cameras: Query<&MainEntity, With<LeanAmbientOcclusion>>,
) {
    warnings.0.keep_only(cameras.iter());
    let (Some(mut pipelines), Some(support)) = (pipelines, support) else {
        return;
    };
    for (entity, view, msaa, settings, lean, has_fog) in &views {
        let reason = (msaa.samples() > 1).then_some("its Msaa is not Off");
        (warnings.0).tell(view.retained_view_entity.main_entity, reason);
        if reason.is_some() {
            commands.entity(entity).remove::<ActiveOcclusion>();
            continue;
        }
        let is_for_lighting = lean.is_some() && settings.is_for_lighting();
        let key = GatherKey {
            kernel: settings.kernel,
            samples: (settings.quality.is_preset()).then(|| settings.quality.samples()),
            // After the opaque meshes, the G-buffer's are those of what forward has drawn over.
            shading_normals: is_for_lighting && settings.normals == OcclusionNormals::Shading,
            thin: settings.thickness < 1.0,
            divisor: settings.resolution.divisor(),
            format: settings.format,
            projection: projection_of(view.clip_from_view),
        };
        let merge = (!is_for_lighting).then(|| {
            pipelines.merge(
                &pipeline_cache,
                MergeKey {
                    target: view.target_format,
                    filter: settings.into(),
                    fog: has_fog,
                    debug_view: settings.debug_view,
                },
            )
        });
        commands.entity(entity).insert(ActiveOcclusion {
            key,
            gather: pipelines.gather(&pipeline_cache, key, support.can_store(settings.format)),
            merge,
        });
    }
}
