//! Decides per camera and frame if reflections run, and with which pipelines.

use bevy::{
    camera::MainPassResolutionOverride,
    prelude::*,
    render::{
        camera::ExtractedCamera, render_resource::PipelineCache, renderer::RenderDevice,
        sync_world::MainEntity, view::ExtractedView,
    },
};

use super::{
    key::ReflectionKey,
    pipelines::{ReflectionPasses, ReflectionPipelines},
    settings::{LeanScreenSpaceReflections, ScreenSpaceReflectionsDebugView},
};
use crate::{
    screen_space::{
        ReadsHistory,
        history_validity::drawn_part,
        support::{EffectOff, NEEDED_LIMITS},
    },
    shader_library::reconstruction::position::projection_of,
    view::{ActiveLeanView, GBufferTargets, IndirectSpecular, LeanDeferred, warn_once::WarnOnce},
};

/// On a view of the render world: the pipelines are compiled, and lighting is asked to add their output.
#[derive(Component, Clone, Copy, Debug)]
pub struct ActiveReflections {
    pub(super) settings: LeanScreenSpaceReflections,
    pub(super) key: ReflectionKey,
    pub(super) passes: ReflectionPasses,
}

/// Inserts or removes [`ActiveReflections`] and its requests to other passes. While pipelines for new settings compile, a view keeps
/// its current ones. Cameras that are switched off lose it, which frees their GPU resources.
pub(super) fn decide_active_reflections(
    mut commands: Commands,
    pipelines: Option<ResMut<ReflectionPipelines>>,
    (cache, device): (Res<PipelineCache>, Res<RenderDevice>),
    mut warnings: Local<WarnOnce<EffectOff>>,
    views: Query<
        (
            Entity,
            &ExtractedView,
            &LeanScreenSpaceReflections,
            Option<&LeanDeferred>,
            Option<&MainPassResolutionOverride>,
            (Option<&ActiveLeanView>, Option<&ActiveReflections>),
        ),
        With<ExtractedCamera>,
    >,
    cameras: Query<&MainEntity, With<LeanScreenSpaceReflections>>,
    switched_off: Query<Entity, (With<ActiveReflections>, Without<ExtractedCamera>)>,
) {
    warnings.keep_only(cameras.iter());
    for entity in &switched_off {
        commands.entity(entity).remove::<ActiveReflections>();
    }
    let Some(mut pipelines) = pipelines else {
        return;
    };
    let limits = device.limits();
    for (entity, view, settings, lean, resolution, (last, current)) in &views {
        let reason = EffectOff::of(NEEDED_LIMITS, &limits).filter(|_| lean.is_some());
        let can_run = reason.is_none() && lean.is_some_and(|lean| lean.enabled);
        let camera = view.retained_view_entity.main_entity;
        warnings.tell("LeanScreenSpaceReflections", camera, reason);
        let rows = drawn_part(view, resolution).height();
        let key = ReflectionKey {
            marches: settings.marches(rows),
            divisor: settings.texel_side(rows),
            // From the last frame: if the target is new, coats reflect one frame late.
            specialization: last
                .is_some_and(|view| view.targets.contains(GBufferTargets::SPECIALIZATION)),
            projection: projection_of(view.clip_from_view),
            shown: settings.debug_view == Some(ScreenSpaceReflectionsDebugView::Hit),
        };
        let wanted = can_run.then(|| ActiveReflections {
            settings: *settings,
            key,
            passes: pipelines.specialize(&cache, key),
        });
        let stand_in = current.filter(|last| last.key.stands_in_for(key)).copied();
        let active = [wanted, stand_in]
            .into_iter()
            .flatten()
            .find(|active| can_run && active.passes.are_compiled(&cache));
        match active {
            Some(active) => {
                let mut view = commands.entity(entity);
                view.insert(active);
                if last.is_some() {
                    view.insert(ReadsHistory);
                    view.insert_if_new(IndirectSpecular::default());
                } else {
                    // The camera was not rendered lean: drop its history and output.
                    view.remove::<ReadsHistory>();
                    view.insert(IndirectSpecular::default());
                }
            }
            None if current.is_some() => {
                commands.entity(entity).remove::<ActiveReflections>();
            }
            None => {}
        }
    }
}
