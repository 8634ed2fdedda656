//! Runs an example in a window or renders it to a PNG.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use crate::headless::Headless;
use bevy::{
    app::PluginGroupBuilder, asset::UnapprovedPathMode, camera::ShadowLodOrigin,
    diagnostic::FrameTimeDiagnosticsPlugin, input::InputSystems, prelude::*,
    render::diagnostic::RenderDiagnosticsPlugin, ui::UiSystems, window::WindowResolution,
};
use bevy_panorbit_camera::PanOrbitCameraPlugin;

use super::{
    debug_view, keys,
    panel::{self, Panel},
    set,
    switch::switch_lights,
    text_panel::spawn_text_panel,
};

/// Ample for a file on disk, even on a software renderer.
const LOADING_TIME: Duration = Duration::from_secs(120);

/// Present once the scene is complete.
#[derive(Resource)]
pub struct SceneReady;

/// Parts that all examples share: a window with keys and a panel, or a PNG for `--headless`. As a plugin, it also sets the runner of
/// the app.
pub struct Example {
    pub title: &'static str,
    pub size: UVec2,
    pub headless: Option<String>,
    /// Shows the panel without a window, too.
    pub text: bool,
    /// Switches the lights of the key L off.
    pub dark: bool,
    /// Settings of the camera: see [`set::apply_all`].
    pub set: Vec<String>,
    /// Writes the picture of `--headless`.
    pub write: Arc<dyn Fn(Headless, &str) -> AppExit + Send + Sync>,
}

impl Example {
    /// An example without options, whose picture is taken after so many frames.
    pub fn with_frames(frames: usize) -> Self {
        Self {
            title: "",
            size: UVec2::new(1280, 720),
            headless: None,
            text: false,
            dark: false,
            set: Vec::new(),
            write: Arc::new(move |headless: Headless, path: &str| {
                write_picture(headless, path, frames)
            }),
        }
    }

    /// Has `write` write the picture of `--headless`.
    pub fn written_by(
        self,
        write: impl Fn(Headless, &str) -> AppExit + Send + Sync + 'static,
    ) -> Self {
        Self {
            write: Arc::new(write),
            ..self
        }
    }

    /// Bevy's default plugins with the window of this example, which may load files from any path, or without a window.
    pub fn set_up(&self, plugins: DefaultPlugins) -> PluginGroupBuilder {
        if self.headless.is_some() {
            return Headless::default_plugins();
        }
        plugins
            .set(WindowPlugin {
                primary_window: Some(Window {
                    title: format!("bevy_lean_deferred {}", self.title),
                    resolution: WindowResolution::new(self.size.x, self.size.y),
                    ..default()
                }),
                ..default()
            })
            .set(AssetPlugin {
                unapproved_path_mode: UnapprovedPathMode::Allow,
                ..default()
            })
    }
}

impl Plugin for Example {
    fn build(&self, app: &mut App) {
        let settings = self.set.clone();
        app.add_plugins(RenderDiagnosticsPlugin)
            .init_resource::<Panel>()
            .add_systems(PostStartup, move |world: &mut World| {
                set::apply_all(world, &settings);
            })
            .add_systems(Update, debug_view::set_tonemapping);
        if self.dark {
            app.add_systems(PostStartup, switch_lights);
        }
        if self.headless.is_none() || self.text {
            app.add_plugins(FrameTimeDiagnosticsPlugin::default())
                .add_systems(Startup, spawn_text_panel)
                .add_systems(PostUpdate, panel::write_text.before(UiSystems::Prepare));
        }
        let Some(path) = self.headless.clone() else {
            app.add_plugins(PanOrbitCameraPlugin)
                .add_systems(PreUpdate, keys::read_keys.after(InputSystems));
            return;
        };
        app.add_systems(PostStartup, set_shadow_lod_origin);
        let (size, write) = (self.size, self.write.clone());
        app.set_runner(move |app| write(Headless::from_app(size, app, |_| {}), &path));
    }
}

/// Without a window, Bevy asks for the camera by which shadows choose their levels of detail.
fn set_shadow_lod_origin(
    mut commands: Commands,
    set: Query<(), With<ShadowLodOrigin>>,
    cameras: Query<Entity, With<Camera3d>>,
) {
    if let Some(camera) = cameras.iter().next().filter(|_| set.is_empty()) {
        commands.entity(camera).insert(ShadowLodOrigin);
    }
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

    // Settings that cannot be applied end the app.
    if let Some(exit) = headless.app.should_exit() {
        return Err(exit);
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
