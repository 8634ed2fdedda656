//! Decides which views are lean in this frame, and with which targets and lighting.

use core::iter::once;

use bevy::{
    camera::{Camera3dDepthLoadOp, CameraMainTextureUsages, visibility::RenderLayers},
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    pbr::ViewKeyCache,
    platform::collections::{HashMap, HashSet},
    prelude::*,
    render::{
        camera::{DirtySpecializations, ExtractedCamera},
        occlusion_culling::OcclusionCulling,
        render_resource::{PipelineCache, TextureFormat, TextureUsages},
        sync_world::MainEntity,
        view::{
            ExtractedView, NoIndirectDrawing, RenderExtractedVisibleEntities, RetainedViewEntity,
        },
    },
};

use super::foreign_depth::others_may_draw_depth;
use crate::{
    ambient_occlusion::LeanScreenSpaceAmbientOcclusion,
    gbuffer::{MotionResolvePipelines, ReadsGBuffer, ViewDemands},
    gpu::pipeline_watch::PipelineWatch,
    lighting::{LightingPipelines, SceneFeatures, ViewLighting},
    shader_library::reconstruction::position::depth_of_surfaces_is_above_zero,
    view::{
        ActiveLeanView, Demand, Effect, EffectStatuses, GBufferTargets, LeanDebugView,
        LeanDeferred, LeanOffReason, LeanSupport, LightingIo, LightingIoQuery, LightingVariants,
        OutOfMemory,
    },
};

fn reason_against(
    camera: &ExtractedCamera,
    view: &ExtractedView,
    is_3d: bool,
    msaa: &Msaa,
    deferred_prepass: bool,
) -> Option<LeanOffReason> {
    let of_depth = LeanOffReason::against_reading_depth(camera, is_3d, msaa);
    if of_depth.is_some() {
        of_depth
    } else if !camera.hdr {
        Some(LeanOffReason::NotHdr)
    } else if view.target_format != TextureFormat::Rgba16Float {
        Some(LeanOffReason::Format(view.target_format))
    } else if deferred_prepass {
        Some(LeanOffReason::DeferredPrepass)
    } else {
        None
    }
}

/// True if, when lighting reads depth, it is above 0 exactly at pixels with a lean mesh.
fn depth_tells_geometry(
    camera: Option<&Camera3d>,
    view: &ExtractedView,
    visible: Option<&RenderExtractedVisibleEntities>,
) -> bool {
    let starts_at_zero = camera
        .is_some_and(|camera| matches!(camera.depth_load_op, Camera3dDepthLoadOp::Clear(0.0)));
    starts_at_zero
        && depth_of_surfaces_is_above_zero(view.clip_from_view)
        && !others_may_draw_depth(visible)
}

/// Decides the draw order of a view that can be lean. The argument of `can_resolve_motion` is true if meshes are culled
/// in two phases.
fn draw_order(
    depth_tells_geometry: bool,
    (depth, normal, motion): (bool, bool, bool),
    occlusion_culling: bool,
    has_light_layers: bool,
    can_resolve_motion: impl FnOnce(bool) -> bool,
) -> ActiveLeanView {
    let draws_in_prepass = depth || normal || motion;
    let culls_in_two_phases = draws_in_prepass && occlusion_culling;
    let resolves_motion = motion
        && !normal
        && (depth || !culls_in_two_phases)
        && can_resolve_motion(culls_in_two_phases);
    ActiveLeanView {
        draws_in_prepass,
        keeps_prepass: normal || (motion && !resolves_motion),
        resolves_motion,
        has_light_layers,
        targets: GBufferTargets::empty(),
        variants: LightingVariants::empty(),
        io: LightingIo::empty(),
        culls_in_two_phases,
        depth_tells_geometry: depth_tells_geometry && !draws_in_prepass,
    }
}

/// Inserts or removes [`ActiveLeanView`], and [`ViewLighting`] on all views that can be lean. A view is active only
/// while the lighting pipelines that it needs in this frame are compiled. Until then forward draws it, so that neither
/// a switch of renderers nor a new kind of light shows a dark frame. New needs of its meshes are met once lighting for
/// them is compiled; until then forward draws those meshes. Cameras that are switched off lose both components, and
/// with them their GPU resources.
pub(super) fn decide_active_views(
    mut commands: Commands,
    support: Res<LeanSupport>,
    (scene, view_keys): (SceneFeatures, Res<ViewKeyCache>),
    (pipelines, mut motion_pipelines, pipeline_cache, pipeline_watch): (
        Option<ResMut<LightingPipelines>>,
        Option<ResMut<MotionResolvePipelines>>,
        Res<PipelineCache>,
        Res<PipelineWatch>,
    ),
    (mut statuses, mut demands, memory): (
        ResMut<EffectStatuses>,
        ResMut<ViewDemands>,
        Res<OutOfMemory>,
    ),
    mut dirty_specializations: ResMut<DirtySpecializations>,
    mut active_before: Local<HashMap<RetainedViewEntity, ActiveLeanView>>,
    mut views: Query<(
        Entity,
        (
            &ExtractedCamera,
            &ExtractedView,
            &Msaa,
            Option<&Camera3d>,
            Option<&RenderLayers>,
            (Option<&RenderExtractedVisibleEntities>, Has<ReadsGBuffer>),
        ),
        (
            Has<DepthPrepass>,
            Has<NormalPrepass>,
            Has<MotionVectorPrepass>,
            Has<DeferredPrepass>,
            (Has<OcclusionCulling>, Has<NoIndirectDrawing>),
        ),
        (
            &LeanDeferred,
            (
                Option<&LeanScreenSpaceAmbientOcclusion>,
                Option<&LeanDebugView>,
            ),
            LightingIoQuery,
        ),
        (Option<&mut ViewLighting>, Option<&ActiveLeanView>),
    )>,
    switched_off: Query<Entity, (With<ViewLighting>, Without<ExtractedCamera>)>,
) {
    for entity in &switched_off {
        commands
            .entity(entity)
            .remove::<(ActiveLeanView, ViewLighting)>();
    }
    let Some(mut pipelines) = pipelines else {
        return;
    };
    if support.deferred.is_err() {
        for (_, (_, view, ..), ..) in &views {
            let main_entity = view.retained_view_entity.main_entity;
            let mut status = statuses.of(main_entity, Effect::Deferred);
            status.is_off_by_device(&support.deferred);
        }
        return;
    }
    // Iterates over all lights.
    let lights = if views.is_empty() {
        default()
    } else {
        scene.lights()
    };
    let mut active_now = HashMap::default();
    let mut candidates = HashSet::<RetainedViewEntity>::default();

    for (entity, camera, prepasses, (settings, effects, io), (lighting, current)) in &mut views {
        let (camera, view, msaa, camera_3d, layers, (visible, is_read)) = camera;
        let is_3d = camera_3d.is_some();
        let main_entity = view.retained_view_entity.main_entity;
        let (depth, normal, motion, deferred, (occlusion_culling, no_indirect)) = prepasses;
        candidates.insert(view.retained_view_entity);
        let reason = (!settings.enabled)
            .then_some(LeanOffReason::Disabled)
            .or_else(|| reason_against(camera, view, is_3d, msaa, deferred));
        let mut status = statuses.of(main_entity, Effect::Deferred);
        if status.is_off_for(reason) || status.is_off_by_memory(memory.label(entity)) {
            commands
                .entity(entity)
                .remove::<(ActiveLeanView, ViewLighting)>();
            continue;
        }
        let Some(view_key) = view_keys.get(&view.retained_view_entity) else {
            status.set_running(false, None);
            continue;
        };
        // A camera has none in its first frame; it is lean at once if everything is compiled.
        let mut new_lighting = None;
        let lighting = match lighting {
            Some(lighting) => lighting.into_inner(),
            None => new_lighting.insert(ViewLighting::default()),
        };

        let order = draw_order(
            !is_read && depth_tells_geometry(camera_3d, view, visible),
            (depth, normal, motion),
            occlusion_culling && !no_indirect,
            scene.has_light_layers(settings, layers),
            |in_two_phases| {
                (motion_pipelines.as_mut())
                    .is_some_and(|pipelines| pipelines.are_ready(&pipeline_cache, in_two_phases))
            },
        );
        let last = active_before.get(&view.retained_view_entity);
        let io = LightingIo::asked(io);
        let before = last.map_or(Demand::default(), ActiveLeanView::demand);
        let held = last.map(|last| last.io);
        let held = held.filter(|held| *held != io);
        // Lighting for lingering demands may never be compiled, so `needed` alone is a choice too.
        let [wanted, needed] = demands.wanted(view.retained_view_entity);
        let choices = if before.contains(needed) {
            [wanted, before, needed]
        } else {
            [wanted, needed, before]
        };
        let choices = choices
            .into_iter()
            .flat_map(|demand| once(io).chain(held).map(move |io| (demand, io)));
        let choices = choices.map(|(demand, io)| {
            let order = ActiveLeanView { io, ..order };
            let Demand { targets, variants } = demand.on(&order);
            let order = ActiveLeanView {
                targets,
                variants,
                ..order
            };
            let key = scene.key(
                lights,
                *view_key,
                view.clip_from_view,
                settings,
                effects,
                &order,
            );
            (order, key)
        });
        let mut compiled = choices.clone().find_map(|(order, key)| {
            if lighting
                .pipelines
                .first()
                .is_none_or(|(now, _)| *now != key)
            {
                lighting.pipelines = key
                    .dispatches()
                    .map(|key| (key, pipelines.specialize(&pipeline_cache, key)))
                    .collect();
            }
            lighting
                .pipelines
                .iter()
                .all(|(_, id)| pipeline_cache.get_compute_pipeline(*id).is_some())
                .then_some(order)
        });
        if compiled.is_none() {
            compiled = choices.into_iter().find_map(|(order, key)| {
                let stand_in = |key| pipelines.compiled(&pipeline_cache, key);
                lighting.pipelines = key.stand_ins().find_map(stand_in)?;
                Some(order)
            });
        }
        let failure = pipeline_watch.failure(lighting.pipelines.iter().map(|(_, id)| id.id()));
        status.set_running(compiled.is_some(), failure);
        if let Some(active) = &compiled {
            statuses.set_lighting(main_entity, active.io);
        }
        if let Some(new) = new_lighting {
            commands.entity(entity).insert(new);
        }
        if let Some(active) = compiled {
            active_now.insert(view.retained_view_entity, active);
            if current != Some(&active) {
                commands.entity(entity).insert(active);
            }
        } else {
            commands.entity(entity).remove::<ActiveLeanView>();
        }
    }

    // `queue_gbuffer_meshes` sorts the meshes of views that are lean or still could be. On other views Bevy must queue
    // them again.
    for view in active_before.keys() {
        if !candidates.contains(view) {
            dirty_specializations.views.insert(*view);
        }
    }
    *active_before = active_now;
}

/// Leaves views whose textures do not fit into memory to Bevy. Runs after the textures of all views are allocated and
/// before meshes are queued.
pub(super) fn withdraw_views_without_memory(
    mut commands: Commands,
    memory: Res<OutOfMemory>,
    mut statuses: ResMut<EffectStatuses>,
    views: Query<(Entity, &MainEntity), With<ActiveLeanView>>,
) {
    for (entity, camera) in &views {
        let mut status = statuses.of(*camera, Effect::Deferred);
        if status.is_off_by_memory(memory.label(entity)) {
            commands
                .entity(entity)
                .remove::<(ActiveLeanView, ViewLighting)>();
        }
    }
}

/// Adds the usage with which lighting writes the main texture. Cameras of one target share that texture only if they
/// request equal usages, so all of them get it.
pub(super) fn make_main_textures_writable(
    lean: Query<&ExtractedCamera, With<ViewLighting>>,
    mut views: Query<(
        &ExtractedCamera,
        &ExtractedView,
        &mut CameraMainTextureUsages,
    )>,
) {
    for (camera, view, mut usages) in &mut views {
        if view.target_format == TextureFormat::Rgba16Float
            && lean.iter().any(|lean| lean.target == camera.target)
        {
            usages.0 |= TextureUsages::STORAGE_BINDING;
        }
    }
}
