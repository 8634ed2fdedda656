//! The inputs of the decision, per view and of the scene.

use bevy::{
    camera::visibility::RenderLayers,
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    pbr::ViewKeyCache,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        occlusion_culling::OcclusionCulling,
        render_resource::PipelineCache,
        view::{
            ExtractedView, NoIndirectDrawing, RenderExtractedVisibleEntities, RetainedViewEntity,
        },
    },
};

use crate::{
    gbuffer::{MotionResolvePipelines, MovingMeshes, ReadsGBuffer, ViewDemands},
    gpu::{
        named::{query_item, system_param},
        pipeline_watch::PipelineWatch,
    },
    lighting::{CompiledLighting, LevelLights, LightingPipelines, SceneFeatures, ViewLighting},
    view::{
        ActiveLeanView, EffectStatuses, LeanDebugView, LeanDeferred, LeanSupport, LightingIoQuery,
        OutOfMemory, Prewarming,
    },
};

query_item! {
    /// The parts of a view with [`LeanDeferred`] that decide if and how it is lean.
    pub(super) struct RequestedViewItem<'w, 's>: RequestedView {
        pub(super) entity: Entity,
        pub(super) camera: &'static ExtractedCamera,
        pub(super) view: &'static ExtractedView,
        pub(super) msaa: &'static Msaa,
        pub(super) camera_3d: Option<&'static Camera3d>,
        pub(super) layers: Option<&'static RenderLayers>,
        pub(super) visible: Option<&'static RenderExtractedVisibleEntities>,
        pub(super) is_read: Has<ReadsGBuffer>,
        pub(super) depth_prepass: Has<DepthPrepass>,
        pub(super) normal_prepass: Has<NormalPrepass>,
        pub(super) motion_prepass: Has<MotionVectorPrepass>,
        pub(super) deferred_prepass: Has<DeferredPrepass>,
        pub(super) occlusion_culling: Has<OcclusionCulling>,
        pub(super) no_indirect_drawing: Has<NoIndirectDrawing>,
        pub(super) settings: &'static LeanDeferred,
        pub(super) debug_view: Option<&'static LeanDebugView>,
        pub(super) io: LightingIoQuery,
        pub(super) lighting: Option<&'static mut ViewLighting>,
        pub(super) current: Option<&'static ActiveLeanView>,
    }
}

impl RequestedViewItem<'_, '_> {
    pub(super) fn id(&self) -> RetainedViewEntity {
        self.view.retained_view_entity
    }
}

system_param! {
    /// Inputs of the decision, without the views themselves.
    pub(super) struct DecisionInputs<'w, 's> {
        pub(super) support: Res<'w, LeanSupport>,
        pub(super) memory: Res<'w, OutOfMemory>,
        pub(super) scene: SceneFeatures<'w, 's>,
        pub(super) level: Res<'w, LevelLights>,
        pub(super) prewarming: ResMut<'w, Prewarming>,
        pub(super) view_keys: Res<'w, ViewKeyCache>,
        pub(super) demands: ResMut<'w, ViewDemands>,
        pub(super) moving_meshes: Res<'w, MovingMeshes>,
        pub(super) lighting_pipelines: Option<ResMut<'w, LightingPipelines>>,
        pub(super) compiled_lighting: Res<'w, CompiledLighting>,
        pub(super) motion_pipelines: Option<ResMut<'w, MotionResolvePipelines>>,
        pub(super) pipeline_cache: ResMut<'w, PipelineCache>,
        pub(super) pipeline_watch: Res<'w, PipelineWatch>,
        pub(super) statuses: ResMut<'w, EffectStatuses>,
    }
}
