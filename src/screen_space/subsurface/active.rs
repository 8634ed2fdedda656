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
    settings::{LeanSubsurfaceScattering, SubsurfaceScatteringQuality},
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
    demands: Res<ViewDemands>,
    mut warnings: Local<WarnOnce<EffectOff>>,
    views: Query<
        (
            Entity,
            &ExtractedView,
            Option<&LeanSubsurfaceScattering>,
            Option<&LeanDeferred>,
            Option<&ActiveScattering>,
        ),
        (
            With<ExtractedCamera>,
            Or<(
                With<LeanDeferred>,
                With<LeanSubsurfaceScattering>,
                With<ActiveScattering>,
            )>,
        ),
    >,
    cameras: Query<&MainEntity, Or<(With<LeanDeferred>, With<LeanSubsurfaceScattering>)>>,
    switched_off: Query<Entity, (With<ActiveScattering>, Without<ExtractedCamera>)>,
) {
    warnings.keep_only(cameras.iter());
    for entity in &switched_off {
        commands.entity(entity).remove::<ActiveScattering>();
    }
    let Some(mut pipelines) = pipelines else {
        return;
    };
    let limits = device.limits();
    for (entity, view, settings, lean, current) in &views {
        let is_asked =
            lean.is_some_and(|lean| lean.enabled) && demands.scatter(view.retained_view_entity);
        let reason = match (settings, lean.is_some()) {
            (Some(settings), false) if settings.quality != SubsurfaceScatteringQuality::Off => {
                Some(EffectOff::NotLean)
            }
            _ => EffectOff::of(true, NEEDED_LIMITS, &limits).filter(|_| is_asked),
        };
        let camera = view.retained_view_entity.main_entity;
        warnings.tell("LeanSubsurfaceScattering", camera, reason);
        let settings = settings.copied().unwrap_or_default();
        let key = SubsurfaceKey::new(settings.quality, projection_of(view.clip_from_view));
        let wanted = key
            .filter(|_| is_asked && reason.is_none())
            .map(|key| ActiveScattering {
                settings,
                key,
                passes: pipelines.specialize(&cache, key),
            });
        let stand_in = current.copied().filter(|last| {
            wanted.is_some_and(|wanted| wanted.key.is_orthographic == last.key.is_orthographic)
        });
        let active = [wanted, stand_in]
            .into_iter()
            .flatten()
            .find(|active| active.passes.are_compiled(&cache));
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
