//! Ends prewarms of cameras that cannot be lean, so that no loading screen waits for ever.

use bevy::{ecs::entity::EntityHashMap, prelude::*};

use super::LeanPrewarm;
use crate::view::{EffectStatus, LeanDeferred, LeanOffReason, LeanStatus, LeanSupport};

/// Frames for which a camera may stay without being rendered, as while its window is minimised.
const PATIENCE: u32 = 120;
/// Frames for which a status may be that of former settings of the camera: it comes from the render world, one or two frames late.
const STALE: u32 = 2;

/// Ends them with a warning that names the reason. Runs in the main world, for apps without a render world.
pub(super) fn end_impossible_prewarms(
    support: Option<Res<LeanSupport>>,
    mut cameras: Query<(
        Entity,
        &mut LeanPrewarm,
        Has<LeanDeferred>,
        Option<&LeanStatus>,
    )>,
    mut waited: Local<EntityHashMap<u32>>,
) {
    waited.retain(|camera, _| cameras.contains(*camera));
    for (camera, mut prewarm, is_lean, status) in &mut cameras {
        if prewarm.progress.is_done {
            waited.remove(&camera);
            continue;
        }
        let Some(reason) = reason_against(support.as_deref(), is_lean, status) else {
            waited.remove(&camera);
            continue;
        };
        let patience = match &reason {
            LeanOffReason::Device(_) | LeanOffReason::NoLeanDeferred => 0,
            LeanOffReason::NotRendered => PATIENCE,
            _ => STALE,
        };
        let frames = waited.entry(camera).or_default();
        *frames += 1;
        if *frames > patience {
            warn!("LeanPrewarm on camera {camera} compiles nothing and is done: {reason}.");
            prewarm.progress.is_done = true;
            waited.remove(&camera);
        }
    }
}

fn reason_against(
    support: Option<&LeanSupport>,
    is_lean: bool,
    status: Option<&LeanStatus>,
) -> Option<LeanOffReason> {
    // Not known before all plugins are finished.
    if let Err(missing) = &support?.deferred {
        return Some(LeanOffReason::Device(missing.clone()));
    }
    if !is_lean {
        return Some(LeanOffReason::NoLeanDeferred);
    }
    match &status?.deferred {
        EffectStatus::Off(reason) => Some(reason.clone()),
        EffectStatus::Absent | EffectStatus::On | EffectStatus::Compiling => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn supported() -> LeanSupport {
        LeanSupport {
            deferred: Ok(()),
            ambient_occlusion_by_compute: Ok(()),
            screen_space: Ok(()),
            subsurface: Ok(()),
            auto_exposure: Ok(()),
        }
    }

    fn is_done(support: LeanSupport, camera: impl Bundle, frames: u32) -> bool {
        let mut world = World::new();
        world.insert_resource(support);
        let camera = world.spawn(camera).id();
        // Without the plugins, the component would be done by itself.
        let mut prewarm = world.get_mut::<LeanPrewarm>(camera).expect("it is there");
        prewarm.progress.is_done = false;
        let mut schedule = Schedule::default();
        schedule.add_systems(end_impossible_prewarms);
        for _ in 0..frames {
            schedule.run(&mut world);
        }
        let prewarm = world.get::<LeanPrewarm>(camera).expect("it is there");
        prewarm.progress.is_done
    }

    fn camera(deferred: EffectStatus) -> impl Bundle {
        let status = LeanStatus {
            deferred,
            ..default()
        };
        (LeanPrewarm::default(), LeanDeferred::default(), status)
    }

    #[test]
    fn cameras_that_cannot_be_lean_are_done_at_once() {
        let unsupported = LeanSupport {
            deferred: Err("compute shaders".into()),
            ..supported()
        };
        assert!(is_done(unsupported, camera(EffectStatus::On), 1));
        assert!(is_done(supported(), LeanPrewarm::default(), 1));
    }

    /// The app may have corrected the settings in the frame in which it inserted `LeanPrewarm`.
    #[test]
    fn a_status_of_former_settings_ends_nothing() {
        let off = || camera(EffectStatus::Off(LeanOffReason::Msaa));
        assert!(!is_done(supported(), off(), STALE));
        assert!(is_done(supported(), off(), STALE + 1));
    }

    #[test]
    fn others_are_waited_for() {
        for status in [EffectStatus::On, EffectStatus::Compiling] {
            assert!(!is_done(supported(), camera(status), 2 * PATIENCE));
        }
        let unrendered = || camera(EffectStatus::Off(LeanOffReason::NotRendered));
        assert!(!is_done(supported(), unrendered(), PATIENCE));
        assert!(is_done(supported(), unrendered(), PATIENCE + 1));
    }
}
