//! Runs an example in a window or renders it to a PNG.

use std::time::{Duration, Instant};

use crate::headless::Headless;
use bevy::{asset::UnapprovedPathMode, prelude::*, window::WindowResolution};
use bevy_lean_deferred::LeanDeferredPlugins;

/// Ample for a file on disk, even on a software renderer.
const LOADING_TIME: Duration = Duration::from_secs(120);

/// Present once the scene is complete.
#[derive(Resource)]
pub struct SceneReady;

/// An app with a window that may load files from any path.
pub fn windowed(title: &str, size: UVec2) -> App {
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: Some(Window {
                    title: title.into(),
                    resolution: WindowResolution::new(size.x, size.y),
                    ..default()
                }),
                ..default()
            })
            .set(AssetPlugin {
                unapproved_path_mode: UnapprovedPathMode::Allow,
                ..default()
            }),
        LeanDeferredPlugins,
    ));
    app
}

/// Calls [`make_ready`], renders `frames` more frames and writes a PNG.
pub fn write_picture(mut headless: Headless, path: &str, frames: usize) -> AppExit {
    if let Err(exit) = make_ready(&mut headless) {
        return exit;
    }
    headless.frames(frames);
    save_picture(&mut headless, path)
}

/// Redirects the cameras of the first frame, which target a missing window, to the picture; waits for [`SceneReady`] and until nothing is
/// loading or compiling. The error is the program's exit status.
pub fn make_ready(headless: &mut Headless) -> Result<(), AppExit> {
    headless.frames(1);
    let target = headless.render_target();
    let world = headless.app.world_mut();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let cameras: Vec<Entity> = cameras.iter(world).collect();
    for camera in cameras {
        world.entity_mut(camera).insert(target.clone());
    }

    let start = Instant::now();
    while !headless.app.world().contains_resource::<SceneReady>() {
        headless.frames(1);
        if let Some(exit) = headless.app.should_exit() {
            return Err(exit);
        }
        if start.elapsed() > LOADING_TIME {
            eprintln!("error: the scene was not loaded within {LOADING_TIME:?}");
            return Err(AppExit::error());
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    headless.settle();
    Ok(())
}

/// Writes the next frame to a PNG.
pub fn save_picture(headless: &mut Headless, path: &str) -> AppExit {
    let picture = headless.capture();
    match picture.try_save(path) {
        Ok(()) => {
            println!("{path}: {}×{}", picture.size.x, picture.size.y);
            AppExit::Success
        }
        Err(error) => {
            eprintln!("error: cannot write {path}: {error}");
            AppExit::error()
        }
    }
}
