//! Decides per camera and frame if reflections run, and with which pipelines.

use bevy::{
    camera::MainPassResolutionOverride,
    prelude::*,
    render::{camera::ExtractedCamera, render_resource::PipelineCache, view::ExtractedView},
};

use super::{
    key::ReflectionKey, pipelines::ReflectionPipelines, settings::LeanScreenSpaceReflections,
};
use crate::{
    effects::{history::ReadsHistory, history_validity::drawn_part},
    gpu::pipeline_watch::PipelineWatch,
    shader_library::reconstruction::position::projection_of,
    view::{
        ActiveLeanView, DebugView, Effect, EffectStatuses, IndirectSpecular, LeanDebugView,
        LeanDeferred, LeanSupport,
    },
};

/// On a view of the render world: the pipelines are compiled, and lighting is asked to add their output.
#[derive(Component, Clone, Copy, Debug)]
pub struct ActiveReflections {
    pub(super) settings: LeanScreenSpaceReflections,
    pub(super) key: ReflectionKey,
    /// The debug view shows the hits of rays.
    pub(super) shows_hits: bool,
}

/// Inserts or removes [`ActiveReflections`] and its requests to other passes. While pipelines for new settings compile, others
/// stand in. Cameras that are switched off lose it, which frees their GPU resources.
pub(super) fn decide_active_reflections(
    mut commands: Commands,
    pipelines: Option<ResMut<ReflectionPipelines>>,
    (cache, watch): (Res<PipelineCache>, Res<PipelineWatch>),
    (support, mut statuses): (Res<LeanSupport>, ResMut<EffectStatuses>),
    views: Query<
        (
            Entity,
            &ExtractedView,
            &LeanScreenSpaceReflections,
            (Option<&LeanDeferred>, Option<&LeanDebugView>),
            Option<&MainPassResolutionOverride>,
            (Has<ActiveLeanView>, Has<ReadsHistory>),
            Option<&ActiveReflections>,
        ),
        With<ExtractedCamera>,
    >,
    switched_off: Query<
        Entity,
        (
            Or<(With<ActiveReflections>, With<ReadsHistory>)>,
            Without<ExtractedCamera>,
        ),
    >,
) {
    for entity in &switched_off {
        let mut view = commands.entity(entity);
        view.remove::<(ActiveReflections, ReadsHistory)>();
    }
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for (entity, view, settings, (lean, debug_view), resolution, last, current) in &views {
        let (was_lean, reads_history) = last;
        let camera = view.retained_view_entity.main_entity;
        let mut status = statuses.of(camera, Effect::Reflections);
        let can_run =
            !status.is_off_without(lean) && !status.is_off_by_device(&support.screen_space);
        let rows = drawn_part(view, resolution).height();
        let wanted = ReflectionKey {
            divisor: settings.steady_texel_side(rows, current.map(|active| active.key.divisor)),
            projection: projection_of(view.clip_from_view),
        };
        let shows_hits = debug_view.is_some_and(|view| view.shows == DebugView::ReflectionHit);
        let key = can_run.then(|| {
            let last = current.map(|active| active.key);
            let key = pipelines.compiled_key(&cache, &watch, wanted, last);
            status.set_running(key.is_some(), pipelines.failure(&watch, wanted));
            key
        });
        match key.flatten() {
            Some(key) => {
                let mut view = commands.entity(entity);
                view.insert(ActiveReflections {
                    settings: *settings,
                    key,
                    shows_hits,
                });
                if was_lean {
                    view.insert_if_new(IndirectSpecular::default());
                } else {
                    // The camera was not rendered lean: drop its output.
                    view.insert(IndirectSpecular::default());
                }
            }
            None if current.is_some() => {
                commands.entity(entity).remove::<ActiveReflections>();
            }
            None => {}
        }
        // Also while pipelines compile, so that there is a last frame when they are.
        if can_run && was_lean {
            commands.entity(entity).insert(ReadsHistory);
        } else if reads_history {
            commands.entity(entity).remove::<ReadsHistory>();
        }
    }
}
