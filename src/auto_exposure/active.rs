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
    pipelines::{ExposurePipelines, PassPipelines},
    prepare::Masks,
    settings::{LeanAutoExposure, MeteringPattern},
    support::ExposureSupport,
};
use crate::view::warn_once::WarnOnce;

/// On a view with auto exposure: the pipelines it is metered with.
#[derive(Component, Clone)]
pub struct ViewExposurePipelines {
    pub(super) key: ExposureKey,
    /// `Some` if the key has a mask.
    pub(super) mask: Option<Handle<Image>>,
    pub(super) passes: PassPipelines,
}

/// The reason that a camera cannot be metered.
fn reason_against(camera: &ExtractedCamera) -> Option<&'static str> {
    if !camera.hdr {
        Some("it has no `Hdr`: insert it")
    } else if camera.schedule != Core3d.intern() && camera.schedule != Core2d.intern() {
        Some("its CameraRenderGraph is neither Core3d nor Core2d")
    } else {
        None
    }
}

/// The reason that the exposure of a metered camera is not applied.
fn reason_not_applied(tonemapping: Option<&Tonemapping>) -> Option<&'static str> {
    let applies = tonemapping.is_some_and(Tonemapping::is_enabled);
    (!applies).then_some(
        "its Tonemapping is None, the default of Camera2d, with which Bevy applies no exposure. Give it another one, such as \
         Tonemapping::TonyMcMapface; what is metered is in MeteredExposure all the same",
    )
}

/// Inserts or removes [`ViewExposurePipelines`]. A view keeps its pipelines until those for new settings are compiled: without any,
/// the image would flash. Cameras that are switched off lose them, which frees their GPU resources except their history.
pub(super) fn queue_exposure_pipelines(
    mut commands: Commands,
    support: Res<ExposureSupport>,
    pipelines: Option<ResMut<ExposurePipelines>>,
    mut warnings: Local<WarnOnce<&'static str>>,
    pipeline_cache: Res<PipelineCache>,
    (masks, mut mask_warnings): (Masks, Local<WarnOnce<&'static str>>),
    mut unapplied_warnings: Local<WarnOnce<&'static str>>,
    mut views: Query<(
        Entity,
        &MainEntity,
        &ExtractedCamera,
        &LeanAutoExposure,
        Option<&Tonemapping>,
        Option<&mut ViewExposurePipelines>,
    )>,
    cameras: Query<&MainEntity, With<LeanAutoExposure>>,
    switched_off: Query<Entity, (With<ViewExposurePipelines>, Without<ExtractedCamera>)>,
) {
    warnings.keep_only(cameras.iter());
    mask_warnings.keep_only(cameras.iter());
    unapplied_warnings.keep_only(cameras.iter());
    for entity in &switched_off {
        commands.entity(entity).remove::<ViewExposurePipelines>();
    }
    let Some(mut pipelines) = pipelines.filter(|_| support.missing.is_none()) else {
        return;
    };
    for (entity, camera, extracted, settings, tonemapping, current) in &mut views {
        let reason = reason_against(extracted);
        warnings.tell("LeanAutoExposure", *camera, reason);
        if reason.is_some() {
            if current.is_some() {
                commands.entity(entity).remove::<ViewExposurePipelines>();
            }
            continue;
        }
        unapplied_warnings.tell_that(
            "is metered, but not applied",
            "LeanAutoExposure",
            *camera,
            reason_not_applied(tonemapping),
        );
        let found = match &settings.pattern {
            MeteringPattern::Mask(mask) => masks.get(mask).map(|image| image.map(|_| mask)),
            _ => Ok(None),
        };
        mask_warnings.tell("The metering mask", *camera, found.err());
        let mask = found.unwrap_or_default();
        let subgroups = support.uses_subgroups(settings);
        let key = ExposureKey::new(settings, subgroups, mask.is_some());
        let passes = pipelines.get(key, &pipeline_cache);
        match current {
            Some(current) if current.key == key && current.mask.as_ref() == mask => {}
            Some(mut current) => {
                if passes.are_compiled(&pipeline_cache) {
                    *current = ViewExposurePipelines {
                        key,
                        mask: mask.cloned(),
                        passes,
                    };
                }
            }
            None => {
                commands.entity(entity).insert(ViewExposurePipelines {
                    key,
                    mask: mask.cloned(),
                    passes,
                });
            }
        }
    }
}
