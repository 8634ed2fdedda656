//! Shows any glTF or GLB file (or a built-in scene) through Bevy forward, Bevy deferred, or this crate.
//!
//! `cargo run --example viewer -- [FILE] [--headless OUT.png] [--help]`
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3 | Bevy forward, Bevy deferred, lean |
//! | D | next debug view of the G-buffer (lean only) |
//! | N | next way to find the geometric normal (lean only) |
//! | L | sun on / off |
//! | E | environment light on / off |
//! | H | text on / off |
//! | mouse | left: orbit, right: pan, wheel: zoom |
//! | Esc | quit |

#[path = "../../tests/common/headless.rs"]
mod headless;
mod model;
mod overlay;
mod renderer;
#[path = "../../tests/common/size.rs"]
mod size;
mod sky;

use std::{
    thread::sleep,
    time::{Duration, Instant},
};

use argh::FromArgs;
use bevy::{
    asset::UnapprovedPathMode, prelude::*, render::diagnostic::RenderDiagnosticsPlugin,
    window::WindowResolution,
};
use bevy_lean_deferred::prelude::*;
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use headless::Headless;
use model::ModelReady;
use renderer::{Renderer, ViewerSettings};
use size::parse_size;
use sky::SkyFiles;

/// Shows a glTF or GLB file, or a built-in scene, through Bevy forward, Bevy deferred, or bevy_lean_deferred.
#[derive(FromArgs)]
struct Args {
    /// the file to show; a built-in scene when left out
    #[argh(positional)]
    file: Option<String>,

    /// forward, deferred or lean (the default)
    #[argh(option, default = "Renderer::Lean")]
    renderer: Renderer,

    /// channel of the G-buffer to show: albedo, metallic, occlusion, normal, roughness, geometric-normal, depth
    #[argh(option, from_str_fn(renderer::parse_channel))]
    debug_view: Option<GBufferChannel>,

    /// render without a window, write this PNG and quit
    #[argh(option)]
    headless: Option<String>,

    /// width x height of the picture or window, default 1280x720
    #[argh(option, default = "UVec2::new(1280, 720)", from_str_fn(parse_size))]
    size: UVec2,

    /// frames before the picture is taken, default 8
    #[argh(option, default = "8")]
    frames: usize,

    /// prefiltered diffuse environment map (KTX2 cube map), with --specular; a made-up sky when left out
    #[argh(option)]
    diffuse: Option<String>,

    /// prefiltered specular environment map (KTX2 cube map), with --diffuse
    #[argh(option)]
    specular: Option<String>,

    /// direction of the camera around the model in degrees, default 25
    #[argh(option, default = "25.0")]
    yaw: f32,

    /// height of the camera over the model in degrees, default 15
    #[argh(option, default = "15.0")]
    pitch: f32,
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    let files = args.file.as_deref().map_or(Ok(()), model::check_file);
    let sky = files.and_then(|()| SkyFiles::new(args.diffuse.clone(), args.specular.clone()));
    let sky = match sky {
        Ok(sky) => sky,
        Err(message) => {
            eprintln!("error: {message}");
            return AppExit::error();
        }
    };
    let viewer = ViewerPlugin {
        settings: ViewerSettings {
            renderer: args.renderer,
            debug_view: args.debug_view,
            ..default()
        },
        model: model::ModelPath(args.file.clone()),
        sky,
        angles: model::CameraAngles {
            yaw: args.yaw.to_radians(),
            pitch: args.pitch.to_radians(),
        },
    };
    match &args.headless {
        Some(path) => run_headless(viewer, path, &args),
        None => run_window(viewer, &args),
    }
}

fn run_window(viewer: ViewerPlugin, args: &Args) -> AppExit {
    App::new()
        .add_plugins((
            DefaultPlugins
                .set(WindowPlugin {
                    primary_window: Some(Window {
                        title: "bevy_lean_deferred viewer".into(),
                        resolution: WindowResolution::new(args.size.x, args.size.y),
                        ..default()
                    }),
                    ..default()
                })
                .set(AssetPlugin {
                    unapproved_path_mode: UnapprovedPathMode::Allow,
                    ..default()
                }),
            LeanDeferredPlugins,
            PanOrbitCameraPlugin,
            viewer,
            overlay::OverlayPlugin,
        ))
        .add_systems(Update, renderer::read_keys)
        .run()
}

/// Plenty for a file on disk.
const LONGEST_LOADING: Duration = Duration::from_secs(120);

fn run_headless(viewer: ViewerPlugin, path: &str, args: &Args) -> AppExit {
    let mut headless = Headless::with(args.size, |app| {
        app.add_plugins(viewer);
    });
    // The camera is spawned in the first frame, for a window that is not there.
    headless.frames(1);
    let target = headless.render_target();
    let world = headless.app.world_mut();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let cameras: Vec<Entity> = cameras.iter(world).collect();
    for camera in cameras {
        world.entity_mut(camera).insert(target.clone());
    }

    let start = Instant::now();
    while !headless.app.world().contains_resource::<ModelReady>() {
        headless.frames(1);
        if let Some(exit) = headless.app.should_exit() {
            return exit;
        }
        if start.elapsed() > LONGEST_LOADING {
            eprintln!("error: not loaded after {LONGEST_LOADING:?}");
            return AppExit::error();
        }
        sleep(Duration::from_millis(10));
    }
    headless.settle();
    headless.frames(args.frames);
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

/// The model, the light, the camera and the renderer that was chosen.
struct ViewerPlugin {
    settings: ViewerSettings,
    model: model::ModelPath,
    sky: SkyFiles,
    angles: model::CameraAngles,
}

impl Plugin for ViewerPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(RenderDiagnosticsPlugin)
            .insert_resource(self.settings.clone())
            .insert_resource(self.model.clone())
            .insert_resource(self.sky.clone())
            .insert_resource(self.angles)
            .add_systems(Startup, (model::spawn_model, sky::spawn_sun, spawn_camera))
            .add_systems(
                Update,
                (
                    model::watch_loading,
                    renderer::apply_settings.run_if(resource_changed::<ViewerSettings>),
                    sky::apply_settings.run_if(resource_changed::<ViewerSettings>),
                ),
            );
    }
}

fn spawn_camera(mut commands: Commands) {
    commands.spawn((
        Camera3d::default(),
        bevy::camera::Hdr,
        Msaa::Off,
        PanOrbitCamera {
            button_orbit: MouseButton::Left,
            button_pan: MouseButton::Right,
            ..default()
        },
        Transform::from_xyz(0.0, 1.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}
