//! Renders scenes with lean and forward cameras and compares the pictures.

use bevy::{
    anti_alias::taa::TemporalAntiAliasing, diagnostic::FrameCount, prelude::*, render::RenderApp,
};
use bevy_lean_deferred::{
    LeanAutoExposure, LeanDeferred,
    effects::{
        ViewHistory, auto_exposure::LeanAutoExposureAdvanced, diffuse_gi::ViewGi,
        reflections::ReflectionBindings,
    },
    lighting::{CompiledLighting, ViewLighting},
    view::ActiveLeanView,
};

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

/// Replaces the app's scene. Pipelines that both scenes need are not compiled again.
pub fn show(headless: &mut Headless, scene: impl FnOnce(&mut SceneBuilder)) {
    let world = headless.world();
    let mut shown = world.query_filtered::<Entity, With<Transform>>();
    let shown: Vec<Entity> = shown.iter(world).collect();
    for entity in shown {
        // It may have been despawned with its parent.
        if let Ok(entity) = world.get_entity_mut(entity) {
            entity.despawn();
        }
    }
    scene(&mut SceneBuilder { headless });
}

/// A picture once all is loaded, always at the same phase of jitter and noise.
pub fn settled(headless: &mut Headless) -> Picture {
    headless.settle();
    begin_phase(headless);
    headless.capture()
}

/// Restarts jitter and noise with the next frame. TAA's history has converged by then.
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

/// Frames after which TAA's history no longer shows the first ones.
const SETTLING_FRAMES: u32 = 64;

/// Period of the jitter, in frames.
const JITTER_PHASES: u32 = 8;

/// Period of the noise, in frames.
const NOISE_PHASES: u32 = 64;

/// True if pictures blend in earlier frames, and so all of their phases.
fn has_history(headless: &mut Headless) -> bool {
    let world = headless.world();
    let mut cameras = world.query_filtered::<(), With<TemporalAntiAliasing>>();
    cameras.iter(world).next().is_some()
}

/// Applies `change` to all cameras.
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

/// Switches all cameras to lean or to forward.
pub fn set_lean(headless: &mut Headless, lean: bool) {
    change_cameras(headless, |camera| {
        if lean {
            camera.insert(LeanDeferred::default());
        } else {
            camera.remove::<LeanDeferred>();
        }
    });
}

/// Auto exposure without adaptation.
pub fn instant_exposure() -> LeanAutoExposure {
    LeanAutoExposure {
        advanced: LeanAutoExposureAdvanced {
            instant: true,
            ..default()
        },
        ..default()
    }
}

/// Number of views rendered lean in the last frame.
pub fn active_lean_views(headless: &mut Headless) -> usize {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    world
        .query_filtered::<(), With<ActiveLeanView>>()
        .iter(world)
        .count()
}

/// Selects the lighting pipelines that the app compiles. It keeps those that it has.
pub fn compile_lighting(app: &mut App, compiled: CompiledLighting) {
    let render_app = app.sub_app_mut(RenderApp);
    render_app.insert_resource(compiled);
}

/// True if general pipelines light a view in the last frame.
pub fn is_lit_by_general(headless: &mut Headless) -> bool {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query_filtered::<&ViewLighting, With<ActiveLeanView>>();
    views.iter(world).any(ViewLighting::is_general)
}

/// For GI, the history of reflections and reflections themselves: true if a view has it, with a valid last frame. All false if no view has
/// both effects.
pub fn follows_last_frame(headless: &mut Headless) -> [bool; 3] {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<(
        Option<&ViewGi>,
        Option<&ViewHistory>,
        Has<ReflectionBindings>,
    )>();
    let mut views = views.iter(world);
    let found = views.find_map(|(gi, history, reflections)| {
        Some([gi?.last().is_some(), history?.last().is_some(), reflections])
    });
    found.unwrap_or_default()
}

/// Prints the difference between `lean` and `forward`; an error if it is too large. Saves both to the folder that `PARITY_PICTURES` names,
/// if set.
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

/// As [`judge`], for each frame of two films.
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

/// Panics if a comparison failed or the validation layer complained.
pub fn report(results: impl IntoIterator<Item = Result<(), String>>) {
    let failures: Vec<String> = results.into_iter().filter_map(Result::err).collect();
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
    log_watch::assert_validation_layer_silent();
}
