//! Warns of cameras that no longer draw into one picture because an effect changed one of them.
//!
//! In Bevy, cameras of one target share a main texture if they have equal `Hdr` and `Msaa`, and depth if they have equal
//! `Msaa`. Otherwise each draws into its own texture, and the later of the two is blended over the other, or replaces it
//! if only one has `Hdr`: Bevy counts the cameras of a target with and without `Hdr` separately, and blends all but the
//! first of each.

use bevy::{
    camera::{Hdr, RenderTarget},
    platform::collections::HashSet,
    prelude::*,
    window::PrimaryWindow,
};

use super::{
    label_of,
    needs::{CameraNeeds, Need},
    record::CameraOverrides,
};

type CameraChanged = (
    Changed<Camera>,
    Changed<RenderTarget>,
    Changed<Msaa>,
    Changed<Hdr>,
    Changed<CameraOverrides>,
);

/// True if some camera has overrides, and some camera changed since the last frame.
pub(crate) fn are_cameras_changed(
    overridden: Query<(), With<CameraOverrides>>,
    changed: Query<(), (With<Camera>, Or<CameraChanged>)>,
    mut removed: RemovedComponents<Hdr>,
) -> bool {
    let removed = removed.read().count() > 0;
    !overridden.is_empty() && (removed || !changed.is_empty())
}

/// Warns once per pair of cameras of one target that overlap, if one lacks settings that effects gave to the other.
pub(crate) fn warn_of_overlaps(
    needs: Res<CameraNeeds>,
    cameras: Query<(EntityRef, &Camera, &RenderTarget)>,
    primary_window: Query<Entity, With<PrimaryWindow>>,
    mut told: Local<HashSet<[Entity; 2]>>,
) {
    told.retain(|pair| pair.iter().all(|camera| cameras.contains(*camera)));
    let primary_window = primary_window.iter().next();
    let active = || cameras.iter().filter(|(_, camera, _)| camera.is_active);
    for (changed, camera, target) in active() {
        let Some(overrides) = changed.get::<CameraOverrides>() else {
            continue;
        };
        let Some(target) = target.normalize(primary_window) else {
            continue;
        };
        for (other, other_camera, other_target) in active() {
            let mut missing = vec![Need::WithoutMsaa, Need::Hdr];
            missing.retain(|need| overrides.holds(changed, *need) && !need.is_met_by(other));
            let [changed_id, other_id] = [changed.id(), other.id()];
            let pair = [changed_id.min(other_id), changed_id.max(other_id)];
            if missing.is_empty()
                || !overlap(camera, other_camera)
                || other_target.normalize(primary_window).as_ref() != Some(&target)
                || !told.insert(pair)
            {
                continue;
            }
            let place = if other_camera.order < camera.order {
                "lies under"
            } else {
                "draws over"
            };
            let [of_changed, of_other] = [changed, other].map(label_of);
            let settings = Need::list(&missing);
            let effects = needs.effects_of(changed, &missing).join(" and ");
            warn!(
                "Camera {of_other} {place} camera {of_changed}, which has {settings} for {effects}: insert {settings} on camera \
                 {of_other} too, or Bevy draws them into two textures, and the later one replaces the other or is blended over it."
            );
        }
    }
}

/// True if the viewports of two cameras overlap. Those of a split screen do not.
fn overlap(one: &Camera, other: &Camera) -> bool {
    let viewports = (one.physical_viewport_rect(), other.physical_viewport_rect());
    matches!(viewports, (Some(one), Some(other)) if !one.intersect(other).is_empty())
}
