//! Decides which views are lean in this frame, and with which targets and lighting.

use bevy::{
    camera::CameraMainTextureUsages,
    platform::collections::{HashMap, HashSet},
    prelude::*,
    render::{
        camera::{DirtySpecializations, ExtractedCamera},
        render_resource::{TextureFormat, TextureUsages},
        sync_world::MainEntity,
        view::{ExtractedView, RetainedViewEntity},
    },
};

use super::{
    candidates::{PipelineSelection, candidates, next_state},
    draw_order::draw_order,
    eligibility::is_eligible,
    inputs::{DecisionInputs, RequestedView, RequestedViewItem},
    prewarm::{request_motion, states_of_level},
};
use crate::{
    lighting::{LightingKey, SceneLights, ViewLighting},
    view::{ActiveLeanView, Effect, EffectStatuses, OutOfMemory},
};

/// The lean views of a frame.
type ActiveViews = HashMap<RetainedViewEntity, ActiveLeanView>;

/// Inserts or removes [`ActiveLeanView`], and [`ViewLighting`] on all views that can be lean. A view is active only
/// while lighting pipelines that fit it in this frame, or general ones, are compiled: forward draws the first frames, so
/// that no switch of renderers shows a dark one. Where general ones do not light the view, new needs of its meshes are
/// met once lighting for them is compiled; until then forward draws those meshes. Cameras that are switched off lose both
/// components, and with them their GPU resources.
pub(super) fn decide_active_views(
    mut commands: Commands,
    mut inputs: DecisionInputs,
    mut dirty_specializations: ResMut<DirtySpecializations>,
    mut active_before: Local<ActiveViews>,
    mut views: Query<RequestedView>,
    switched_off: Query<Entity, (With<ViewLighting>, Without<ExtractedCamera>)>,
) {
    for entity in &switched_off {
        leave_to_bevy(&mut commands, entity);
    }
    if inputs.lighting_pipelines.is_none() {
        return;
    }
    if inputs.support.deferred.is_err() {
        for view in &mut views {
            let camera = RequestedViewItem::of(view).id().main_entity;
            let mut status = inputs.statuses.of(camera, Effect::Deferred);
            status.is_off_by_device(&inputs.support.deferred);
        }
        return;
    }
    // Iterates over all lights.
    let lights = (!views.is_empty()).then(|| inputs.scene.lights());
    let lights = lights.unwrap_or_default();
    let mut active_now = ActiveViews::default();
    let mut requested = HashSet::default();
    for view in &mut views {
        let view = RequestedViewItem::of(view);
        let id = view.id();
        let last = active_before.get(&id);
        requested.insert(id);
        if let Some(active) = decide(view, last, lights, &mut inputs, &mut commands) {
            active_now.insert(id, active);
        }
    }
    requeue_former_views(&mut dirty_specializations, &active_before, &requested);
    *active_before = active_now;
}

/// Decides for one view. Returns its state if it is lean in this frame; `last` is that of the frame before.
fn decide(
    mut view: RequestedViewItem,
    last: Option<&ActiveLeanView>,
    lights: SceneLights,
    inputs: &mut DecisionInputs,
    commands: &mut Commands,
) -> Option<ActiveLeanView> {
    if !is_eligible(&view, &inputs.memory, &mut inputs.statuses) {
        leave_to_bevy(commands, view.entity);
        return None;
    }
    let id = view.id();
    let Some(view_key) = inputs.view_keys.get(&id).copied() else {
        let mut status = inputs.statuses.of(id.main_entity, Effect::Deferred);
        status.set_running(false, None);
        return None;
    };
    // A camera has none in its first frame; it is lean at once if everything is compiled.
    let mut new_lighting = None;
    let lighting = match view.lighting.take() {
        Some(lighting) => lighting.into_inner(),
        None => new_lighting.insert(ViewLighting::default()),
    };
    let order = draw_order(&view, inputs);
    let meshes_move = !inputs.moving_meshes.is_empty();
    let wanted = (inputs.demands).wanted(id, order, last, meshes_move, &inputs.pipeline_cache);
    let (settings, debug_view) = (view.settings, view.debug_view);
    let clip_from_view = view.view.clip_from_view;
    let scene = &inputs.scene;
    let key = |active: &ActiveLeanView| {
        scene.key(
            lights,
            view_key,
            clip_from_view,
            settings,
            debug_view,
            active,
        )
    };
    let prewarmed = inputs.prewarming.get_mut(id.main_entity);
    let candidates = candidates(&view, order, wanted).map(|active| (active, key(&active)));
    let mut selection = PipelineSelection {
        pipelines: inputs.lighting_pipelines.as_deref_mut()?,
        cache: &mut inputs.pipeline_cache,
        compiled: *inputs.compiled_lighting,
        watch: &inputs.pipeline_watch,
        is_prewarmed: prewarmed.is_some(),
    };
    let active = selection.best(candidates, lighting);
    if let Some(next) = next_state(&view, order, wanted) {
        selection.request(key(&next), lighting);
    }
    if let Some(camera) = prewarmed {
        let is_new = camera.view.is_none();
        if is_new {
            selection.pipelines.forget_level(id.main_entity);
        }
        request_motion(
            &view,
            camera.all_features(),
            order.culls_in_two_phases,
            inputs.motion_pipelines.as_deref_mut(),
            (selection.cache, &inputs.pipeline_watch),
        );
        let states = states_of_level(&view, order, camera);
        let states: Vec<LightingKey> = states.map(|state| key(&state)).collect();
        let levels = states
            .into_iter()
            .flat_map(|now| scene.level_keys(now, &inputs.level, &camera.features, settings));
        let levels: Vec<LightingKey> = levels.collect();
        let is_now = camera.requests_lighting;
        camera.awaited_lighting = selection.prewarm(id.main_entity, levels, is_now);
    }
    set_status(&view, active.as_ref(), lighting, inputs);
    apply(commands, &view, new_lighting, active);
    active
}

/// Sets the status of a view that can be lean: on if it is `active`, or why its pipelines are not compiled.
fn set_status(
    view: &RequestedViewItem,
    active: Option<&ActiveLeanView>,
    lighting: &ViewLighting,
    inputs: &mut DecisionInputs,
) {
    let camera = view.id().main_entity;
    let pipelines = lighting.pipelines.iter().map(|(_, id)| id.id());
    let failure = inputs.pipeline_watch.failure(pipelines);
    let mut status = inputs.statuses.of(camera, Effect::Deferred);
    status.set_running(active.is_some(), failure);
    if let Some(active) = active {
        inputs.statuses.set_lighting(camera, active.io);
    }
}

/// Inserts the components of a view that can be lean, where they are new.
fn apply(
    commands: &mut Commands,
    view: &RequestedViewItem,
    new_lighting: Option<ViewLighting>,
    active: Option<ActiveLeanView>,
) {
    let mut entity = commands.entity(view.entity);
    if let Some(lighting) = new_lighting {
        entity.insert(lighting);
    }
    match active {
        Some(active) if view.current == Some(&active) => {}
        Some(active) => {
            entity.insert(active);
        }
        None => {
            entity.remove::<ActiveLeanView>();
        }
    }
}

/// Frees the resources of a lean view. Bevy renders its camera.
fn leave_to_bevy(commands: &mut Commands, view: Entity) {
    commands
        .entity(view)
        .remove::<(ActiveLeanView, ViewLighting)>();
}

/// Has Bevy queue the meshes of views that lost `LeanDeferred`. Those of views that are lean or still could be are sorted
/// by `queue_gbuffer_meshes`.
fn requeue_former_views(
    dirty: &mut DirtySpecializations,
    active_before: &ActiveViews,
    requested: &HashSet<RetainedViewEntity>,
) {
    for view in active_before.keys() {
        if !requested.contains(view) {
            dirty.views.insert(*view);
        }
    }
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
            leave_to_bevy(&mut commands, entity);
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
