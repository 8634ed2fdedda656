//! Showing a scene through lean cameras and through forward ones, and comparing the pictures.

use bevy::{
    diagnostic::FrameCount,
    prelude::*,
    render::{RenderApp, camera::TemporalJitter},
};
use bevy_lean_deferred::{LeanDeferred, view::ActiveLeanView};

use super::{
    headless::{Headless, Picture},
    log_watch,
    metrics::difference,
    scenes::SceneBuilder,
};

/// An app that shows `scene`.
pub fn build(size: UVec2, scene: impl FnOnce(&mut SceneBuilder)) -> Headless {
    let mut headless = Headless::new(size);
    scene(&mut SceneBuilder {
        headless: &mut headless,
    });
    headless
}

/// Shows `scene` in place of what the app has shown. Pipelines that both need are not compiled again.
pub fn show(headless: &mut Headless, scene: impl FnOnce(&mut SceneBuilder)) {
    let world = headless.world();
    let mut shown = world.query_filtered::<Entity, With<Transform>>();
    let shown: Vec<Entity> = shown.iter(world).collect();
    for entity in shown {
        // Not if it went with its parent.
        if let Ok(entity) = world.get_entity_mut(entity) {
            entity.despawn();
        }
    }
    scene(&mut SceneBuilder { headless });
}

/// A picture once all is loaded. Always of the same phase of what changes from frame to frame (jitter, noise).
pub fn settled(headless: &mut Headless) -> Picture {
    headless.settle();
    begin_phase(headless);
    headless.capture()
}

/// Has jitter and noise begin anew in the next frame. What TAA holds of earlier frames has settled by then.
pub fn begin_phase(headless: &mut Headless) {
    let has_history = has_history(headless);
    let made = headless.world().resource::<FrameCount>().0;
    if has_history {
        let until = (made + SETTLING_FRAMES).next_multiple_of(JITTER_PHASES);
        headless.frames((until - made) as usize);
    } else {
        headless.world().resource_mut::<FrameCount>().0 = made.next_multiple_of(NOISE_PHASES);
    }
}

/// After so many frames the first ones no longer show in what TAA holds.
const SETTLING_FRAMES: u32 = 64;

/// After so many frames jitter begins anew.
const JITTER_PHASES: u32 = 8;

/// After so many frames noise begins anew.
const NOISE_PHASES: u32 = 64;

/// Whether pictures hold something of earlier frames, and so of each of their phases.
fn has_history(headless: &mut Headless) -> bool {
    let world = headless.world();
    let mut cameras = world.query_filtered::<(), With<TemporalJitter>>();
    cameras.iter(world).next().is_some()
}

/// Changes all cameras.
pub fn change_cameras(headless: &mut Headless, change: impl Fn(&mut EntityWorldMut)) {
    let world = headless.world();
    let cameras: Vec<Entity> = world
        .query_filtered::<Entity, With<Camera3d>>()
        .iter(world)
        .collect();
    for camera in cameras {
        change(&mut world.entity_mut(camera));
    }
}

/// Switches all cameras over.
pub fn set_lean(headless: &mut Headless, lean: bool) {
    change_cameras(headless, |camera| {
        if lean {
            camera.insert(LeanDeferred::default());
        } else {
            camera.remove::<LeanDeferred>();
        }
    });
}

/// How many views were rendered lean in the last frame.
pub fn active_lean_views(headless: &mut Headless) -> usize {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    world
        .query_filtered::<(), With<ActiveLeanView>>()
        .iter(world)
        .count()
}

/// Prints how far `lean` is from `forward`; an error if that is too far. Writes both into the folder that
/// `PARITY_PICTURES` names, if it does.
pub fn judge(name: &str, forward: &Picture, lean: &Picture, least_psnr: f64) -> Result<(), String> {
    if let Some(folder) = std::env::var_os("PARITY_PICTURES") {
        let folder = std::path::Path::new(&folder);
        forward.save(folder.join(format!("{name}_forward.png")));
        lean.save(folder.join(format!("{name}_lean.png")));
    }
    let difference = difference(forward, lean);
    let line = format!("{name:32} {difference}");
    println!("{line}");
    if difference.psnr < least_psnr {
        return Err(format!("{line}, less than {least_psnr} dB"));
    }
    Ok(())
}

/// As [`judge`], of each frame of two films.
pub fn judge_film(
    name: &str,
    forward: &[Picture],
    lean: &[Picture],
    least_psnr: f64,
) -> Vec<Result<(), String>> {
    assert_eq!(forward.len(), lean.len(), "both films are as long");
    let pairs = forward.iter().zip(lean).enumerate();
    pairs
        .map(|(frame, (forward, lean))| {
            judge(&format!("{name}_{frame:02}"), forward, lean, least_psnr)
        })
        .collect()
}

/// Panics if a comparison failed, or the validation layer has complained.
pub fn report(results: impl IntoIterator<Item = Result<(), String>>) {
    let failures: Vec<String> = results.into_iter().filter_map(Result::err).collect();
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
    log_watch::assert_validation_layer_silent();
}
