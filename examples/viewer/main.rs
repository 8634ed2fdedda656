//! Shows any glTF or GLB file (or a built-in scene) through Bevy forward, Bevy deferred, or this crate.
//!
//! `cargo run --example viewer -- [FILE] [--headless OUT.png] [--help]`
//!
//! Drag a .gltf or .glb file onto the window to show it. If that fails, the old one stays, and the text says why. On Wayland
//! `winit` 0.30 reports no dropped files: unset `WAYLAND_DISPLAY`, to run under X11.
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3 | Bevy forward, Bevy deferred, lean |
//! | D | next debug view of the G-buffer or of light (lean only) |
//! | B | debug view on the whole picture / on its left half |
//! | L | sun on / off |
//! | E | environment light on / off |
//! | H | text on / off |
//! | mouse | left: orbit, right: pan, wheel: zoom |
//! | file, dropped onto the window | replaces the model |
//! | Esc | quit |

mod builtin;
mod overlay;
mod renderer;
mod sky;

use argh::FromArgs;
use bevy::{prelude::*, render::diagnostic::RenderDiagnosticsPlugin, ui::IsDefaultUiCamera};
use bevy_lean_deferred::prelude::*;
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use kit::{
    example::{
        debug_view::{DebugChoice, debug_view},
        dropped_model::DroppedModelPlugin,
        model,
        numbers::share,
        run,
    },
    headless::Headless,
    renderer::Renderer,
    size::parse_size,
};
use renderer::ViewerSettings;
use sky::SkyFiles;

/// Shows a glTF or GLB file, or a built-in scene, through Bevy forward, Bevy deferred, or bevy_lean_deferred. Drag another file
/// onto the window to show that.
#[derive(FromArgs)]
struct Args {
    /// the file to show; a built-in scene when left out
    #[argh(positional)]
    file: Option<String>,

    /// forward, deferred or lean (the default)
    #[argh(option, default = "Renderer::Lean")]
    renderer: Renderer,

    /// data to show instead of the picture, such as albedo, normal, depth, diffuse-light or specular-light
    #[argh(option, from_str_fn(debug_view))]
    debug_view: Option<DebugView>,

    /// share of the width, from the left, that shows them, 0 to 1 (the default)
    #[argh(option, default = "1.0", from_str_fn(share))]
    split: f32,

    /// render without a window, write this PNG and quit
    #[argh(option)]
    headless: Option<String>,

    /// width x height of the picture or window, default 1280x720
    #[argh(option, default = "UVec2::new(1280, 720)", from_str_fn(parse_size))]
    size: UVec2,

    /// show the text in the picture of --headless too
    #[argh(switch)]
    text: bool,

    /// frames before the picture is taken, default 8
    #[argh(option, default = "8")]
    frames: usize,

    /// prefiltered diffuse environment map (KTX2 cube map), with --specular; a procedural sky when left out
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
            debug: DebugChoice {
                view: args.debug_view,
                split: args.split,
            },
            ..default()
        },
        model: model::ModelPath(args.file.clone()),
        sky,
        viewpoint: model::Viewpoint {
            yaw: args.yaw.to_radians(),
            pitch: args.pitch.to_radians(),
            zoom: 1.0,
        },
    };
    match &args.headless {
        Some(path) => {
            let headless = Headless::with(args.size, |app| {
                app.add_plugins(viewer);
                if args.text {
                    app.add_plugins(overlay::OverlayPlugin);
                }
            });
            run::write_picture(headless, path, args.frames)
        }
        None => run::windowed("bevy_lean_deferred viewer", args.size)
            .add_plugins((
                PanOrbitCameraPlugin,
                viewer,
                DroppedModelPlugin,
                overlay::OverlayPlugin,
            ))
            .add_systems(Update, renderer::read_keys)
            .run(),
    }
}

/// The model, the light, the camera and the chosen renderer.
struct ViewerPlugin {
    settings: ViewerSettings,
    model: model::ModelPath,
    sky: SkyFiles,
    viewpoint: model::Viewpoint,
}

impl Plugin for ViewerPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(RenderDiagnosticsPlugin)
            .insert_resource(self.settings.clone())
            .insert_resource(self.model.clone())
            .insert_resource(self.sky.clone())
            .insert_resource(self.viewpoint)
            .add_systems(
                Startup,
                (
                    model::spawn_model,
                    builtin::spawn.run_if(model::is_builtin),
                    sky::spawn_sun,
                    spawn_camera,
                ),
            )
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
        IsDefaultUiCamera,
        PanOrbitCamera {
            button_orbit: MouseButton::Left,
            button_pan: MouseButton::Right,
            ..default()
        },
        Transform::from_xyz(0.0, 1.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}
