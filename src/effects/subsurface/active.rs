//! Decides per camera and frame if light scatters, and with which pipelines.

use bevy::{
    prelude::*,
    render::{camera::ExtractedCamera, render_resource::PipelineCache, view::ExtractedView},
};

use super::{
    key::SubsurfaceKey, pipelines::SubsurfacePipelines, settings::LeanSubsurfaceScattering,
};
use crate::{
    gbuffer::ViewDemands,
    gpu::pipeline_watch::PipelineWatch,
    view::{
        Effect, EffectStatuses, LeanDeferred, LeanOffReason, LeanSupport, Prewarming, ScattersLight,
    },
};

/// On a view of the render world: a surface in it scatters light, the pipelines are compiled, and lighting writes the light that
/// enters to a target of its own.
#[derive(Component, Clone, Copy, Debug)]
pub struct ActiveScattering {
    pub(super) settings: LeanSubsurfaceScattering,
    pub(super) key: SubsurfaceKey,
}

/// Inserts or removes [`ActiveScattering`] and its request to lighting. While pipelines for new settings compile, others stand
/// in. Cameras that are switched off lose it.
pub(super) fn decide_active_scattering(
    mut commands: Commands,
    pipelines: Option<ResMut<SubsurfacePipelines>>,
    (cache, watch): (Res<PipelineCache>, Res<PipelineWatch>),
    // Missing without `LeanDeferredPlugin`.
    demands: Option<Res<ViewDemands>>,
    mut prewarming: ResMut<Prewarming>,
    (support, mut statuses): (Res<LeanSupport>, ResMut<EffectStatuses>),
    views: Query<
        (
            Entity,
            &ExtractedView,
            &LeanSubsurfaceScattering,
            Option<&LeanDeferred>,
            Option<&ActiveScattering>,
        ),
        With<ExtractedCamera>,
    >,
    switched_off: Query<Entity, (With<ActiveScattering>, Without<ExtractedCamera>)>,
) {
    for entity in &switched_off {
        commands.entity(entity).remove::<ActiveScattering>();
    }
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for (entity, view, settings, lean, current) in &views {
        let scatters =
            (demands.as_ref()).is_some_and(|demands| demands.scatter(view.retained_view_entity));
        let camera = view.retained_view_entity.main_entity;
        if support.subsurface.is_ok() && prewarming.scatters(camera) {
            pipelines.specialize(&cache, &watch, SubsurfaceKey::new(settings.quality));
        }
        let mut status = statuses.of(camera, Effect::Subsurface);
        let can_run = !status.is_off_without(lean)
            && !status.is_off_for((!scatters).then_some(LeanOffReason::NothingScatters))
            && !status.is_off_by_device(&support.subsurface);
        let wanted = SubsurfaceKey::new(settings.quality);
        let key = can_run.then(|| {
            let last = current.map(|active| active.key);
            let key = pipelines.compiled_key(&cache, &watch, wanted, last);
            status.set_running(key.is_some(), pipelines.failure(&watch, wanted));
            key
        });
        match key.flatten() {
            Some(key) => {
                let settings = *settings;
                let active = ActiveScattering { settings, key };
                commands.entity(entity).insert((active, ScattersLight));
            }
            None if current.is_some() => {
                commands.entity(entity).remove::<ActiveScattering>();
            }
            None => {}
        }
    }
}
