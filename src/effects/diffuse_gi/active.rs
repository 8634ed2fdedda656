//! Decides per camera and frame if diffuse GI runs, and with which pipelines.

use bevy::{
    prelude::*,
    render::{camera::ExtractedCamera, render_resource::PipelineCache, view::ExtractedView},
};

use super::{key::GiKey, pipelines::GiPipelines, settings::LeanScreenSpaceGi};
use crate::{
    gpu::pipeline_watch::PipelineWatch,
    shader_library::reconstruction::position::projection_of,
    view::{
        ActiveLeanView, Effect, EffectStatuses, IndirectDiffuse, LeanDeferred, LeanSupport,
        ReadsDiffuseLight,
    },
};

/// On a view of the render world: the pipelines are compiled, and lighting is asked to add their output.
#[derive(Component, Clone, Copy, Debug)]
pub struct ActiveGi {
    pub(super) settings: LeanScreenSpaceGi,
    pub(super) key: GiKey,
}

/// Inserts or removes [`ActiveGi`] and its requests to lighting. While pipelines for new settings compile, others stand in.
/// Cameras that are switched off lose it, which frees their GPU resources.
pub(super) fn decide_active_gi(
    mut commands: Commands,
    pipelines: Option<ResMut<GiPipelines>>,
    (cache, watch): (Res<PipelineCache>, Res<PipelineWatch>),
    (support, mut statuses): (Res<LeanSupport>, ResMut<EffectStatuses>),
    views: Query<
        (
            Entity,
            &ExtractedView,
            &LeanScreenSpaceGi,
            Option<&LeanDeferred>,
            (Has<ActiveLeanView>, Option<&ActiveGi>),
        ),
        With<ExtractedCamera>,
    >,
    switched_off: Query<Entity, (With<ActiveGi>, Without<ExtractedCamera>)>,
) {
    for entity in &switched_off {
        commands.entity(entity).remove::<ActiveGi>();
    }
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for (entity, view, settings, lean, (was_lean, current)) in &views {
        let camera = view.retained_view_entity.main_entity;
        let mut status = statuses.of(camera, Effect::DiffuseGi);
        let can_run =
            !status.is_off_without(lean) && !status.is_off_by_device(&support.screen_space);
        let wanted = GiKey {
            samples: settings.samples(),
            projection: projection_of(view.clip_from_view),
        };
        let key = can_run.then(|| {
            let last = current.map(|active| active.key);
            let key = pipelines.compiled_key(&cache, &watch, wanted, last);
            status.set_running(key.is_some(), pipelines.failure(&watch, wanted));
            key
        });
        match key.flatten() {
            Some(key) => {
                let settings = *settings;
                let mut view = commands.entity(entity);
                view.insert((ActiveGi { settings, key }, ReadsDiffuseLight));
                if was_lean {
                    view.insert_if_new(IndirectDiffuse::default());
                } else {
                    // The camera was not rendered lean: drop its output.
                    view.insert(IndirectDiffuse::default());
                }
            }
            None if current.is_some() => {
                commands.entity(entity).remove::<ActiveGi>();
            }
            None => {}
        }
    }
}
