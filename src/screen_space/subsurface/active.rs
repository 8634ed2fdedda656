//! Decides per camera and frame if light scatters, and with which pipelines.

use bevy::{
    prelude::*,
    render::{
        camera::ExtractedCamera, render_resource::PipelineCache, renderer::RenderDevice,
        sync_world::MainEntity, view::ExtractedView,
    },
};

use super::{
    key::SubsurfaceKey,
    pipelines::{SubsurfacePasses, SubsurfacePipelines},
    settings::LeanSubsurfaceScattering,
    support::NEEDED_LIMITS,
};
use crate::{
    gbuffer::ViewDemands,
    screen_space::support::EffectOff,
    shader_library::reconstruction::position::projection_of,
    view::{LeanDeferred, ScattersLight, warn_once::WarnOnce},
};

/// On a view of the render world: a surface in it scatters light, the pipelines are compiled, and lighting writes the light that
/// enters to a target of its own.
#[derive(Component, Clone, Copy, Debug)]
pub struct ActiveScattering {
    pub(super) settings: LeanSubsurfaceScattering,
    pub(super) key: SubsurfaceKey,
    pub(super) passes: SubsurfacePasses,
}

/// Inserts or removes [`ActiveScattering`] and its request to lighting. While pipelines for new settings compile, a view keeps its
/// current ones. Cameras that are switched off lose it.
pub(super) fn decide_active_scattering(
    mut commands: Commands,
    pipelines: Option<ResMut<SubsurfacePipelines>>,
    (cache, device): (Res<PipelineCache>, Res<RenderDevice>),
    // Missing without `LeanDeferredPlugin`.
    demands: Option<Res<ViewDemands>>,
    mut warnings: Local<WarnOnce<EffectOff>>,
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
    cameras: Query<&MainEntity, With<LeanSubsurfaceScattering>>,
    switched_off: Query<Entity, (With<ActiveScattering>, Without<ExtractedCamera>)>,
) {
    warnings.keep_only(cameras.iter());
    for entity in &switched_off {
        commands.entity(entity).remove::<ActiveScattering>();
    }
    let (Some(mut pipelines), Some(demands)) = (pipelines, demands) else {
        return;
    };
    let limits = device.limits();
    for (entity, view, settings, lean, current) in &views {
        let is_asked =
            lean.is_some_and(|lean| lean.enabled) && demands.scatter(view.retained_view_entity);
        // A camera that sees nothing of the kind needs no warning.
        let reason = EffectOff::of(NEEDED_LIMITS, &limits).filter(|_| is_asked);
        let can_run = is_asked && reason.is_none();
        let camera = view.retained_view_entity.main_entity;
        warnings.tell("LeanSubsurfaceScattering", camera, reason);
        let key = SubsurfaceKey::new(settings.quality, projection_of(view.clip_from_view));
        let wanted = can_run.then(|| ActiveScattering {
            settings: *settings,
            key,
            passes: pipelines.specialize(&cache, key),
        });
        let stand_in = current
            .filter(|last| last.key.is_orthographic == key.is_orthographic)
            .copied();
        let active = [wanted, stand_in]
            .into_iter()
            .flatten()
            .find(|active| can_run && active.passes.are_compiled(&cache));
        match active {
            Some(active) => {
                commands.entity(entity).insert((active, ScattersLight));
            }
            None if current.is_some() => {
                commands.entity(entity).remove::<ActiveScattering>();
            }
            None => {}
        }
    }
}
