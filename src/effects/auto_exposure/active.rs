//! Decides per camera and frame if it is metered, and with which pipelines.

use bevy::{
    core_pipeline::{
        schedule::{Core2d, Core3d},
        tonemapping::Tonemapping,
    },
    ecs::schedule::ScheduleLabel,
    prelude::*,
    render::{camera::ExtractedCamera, render_resource::PipelineCache, sync_world::MainEntity},
};

use super::{
    key::ExposureKey,
    masks::Masks,
    pipelines::ExposurePipelines,
    settings::{LeanAutoExposure, MeteringPattern},
    support::uses_subgroups,
};
use crate::{
    gpu::{pipeline_watch::PipelineWatch, subgroups::Subgroups},
    view::{Effect, EffectStatuses, LeanOffReason, LeanSupport, warn_once::WarnOnce},
};

/// On a view with auto exposure: how it is metered. The first time, its pipelines may still be compiling.
#[derive(Component, Clone, PartialEq)]
pub struct ActiveExposure {
    pub(super) key: ExposureKey,
    /// `None` until it is loaded.
    pub(super) mask: Option<Handle<Image>>,
}

/// The reason that a camera cannot be metered.
fn reason_against(camera: &ExtractedCamera) -> Option<LeanOffReason> {
    if !camera.hdr {
        Some(LeanOffReason::NotHdr)
    } else if camera.schedule != Core3d.intern() && camera.schedule != Core2d.intern() {
        Some(LeanOffReason::ExposureSchedule)
    } else {
        None
    }
}

/// The reason that the exposure of a metered camera is not applied.
fn reason_not_applied(tonemapping: Option<&Tonemapping>) -> Option<LeanOffReason> {
    let applies = tonemapping.is_some_and(Tonemapping::is_enabled);
    (!applies).then_some(LeanOffReason::NoTonemapping)
}

/// Inserts or removes [`ActiveExposure`]. While pipelines for new settings compile, others stand in: without any, the
/// image would flash. Cameras that are switched off lose them, which frees their GPU resources except their history.
pub(super) fn decide_active_exposure(
    mut commands: Commands,
    (support, subgroups): (Res<LeanSupport>, Res<Subgroups>),
    pipelines: Option<ResMut<ExposurePipelines>>,
    mut statuses: ResMut<EffectStatuses>,
    (pipeline_cache, watch): (Res<PipelineCache>, Res<PipelineWatch>),
    (masks, mut mask_warnings): (Masks, Local<WarnOnce<&'static str>>),
    mut views: Query<(
        Entity,
        &MainEntity,
        &ExtractedCamera,
        &LeanAutoExposure,
        Option<&Tonemapping>,
        Option<&mut ActiveExposure>,
    )>,
    cameras: Query<&MainEntity, With<LeanAutoExposure>>,
    switched_off: Query<Entity, (With<ActiveExposure>, Without<ExtractedCamera>)>,
) {
    mask_warnings.keep_only(cameras.iter());
    for entity in &switched_off {
        commands.entity(entity).remove::<ActiveExposure>();
    }
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for (entity, camera, extracted, settings, tonemapping, current) in &mut views {
        let mut status = statuses.of(*camera, Effect::AutoExposure);
        if status.is_off_by_device(&support.auto_exposure)
            || status.is_off_for(reason_against(extracted))
        {
            if current.is_some() {
                commands.entity(entity).remove::<ActiveExposure>();
            }
            continue;
        }
        let found = match &settings.pattern {
            MeteringPattern::Mask(mask) => masks.get(mask).map(|image| image.map(|_| mask)),
            _ => Ok(None),
        };
        mask_warnings.tell("The metering mask", *camera, found.err());
        let mask = found.unwrap_or_default();
        let subgroups = uses_subgroups(*subgroups, settings);
        let wanted = ExposureKey::new(settings, subgroups, mask.is_some());
        let last = current.as_ref().map(|active| active.key);
        let key = pipelines.compiled_key(&pipeline_cache, &watch, wanted, last);
        if !status.is_off_for(reason_not_applied(tonemapping)) {
            status.set_running(key.is_some(), pipelines.failure(&watch, wanted));
        }
        let active = ActiveExposure {
            key: key.or(last).unwrap_or(wanted),
            mask: mask.cloned(),
        };
        match current {
            Some(mut current) => {
                current.set_if_neq(active);
            }
            None => {
                commands.entity(entity).insert(active);
            }
        }
    }
}
