//! Diffuse GI and reflections: a room with coloured walls and mirrors of four roughnesses (or any glTF or GLB file).
//!
//! `cargo run --example screen_space -- [FILE] [--headless OUT.png] [--help]`
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3 | no effect, `LeanScreenSpaceAmbientOcclusion`, `LeanScreenSpaceGi` |
//! | Q | next quality |
//! | R | full / half resolution |
//! | Up, Down | larger, smaller radius |
//! | M | `LeanScreenSpaceReflections`: off, low, medium, high, ultra; then Bevy's `ScreenSpaceReflections`, without other effects |
//! | D | picture / debug views: light and visibility of GI; light, confidence and hits of reflections |
//! | B | debug view on the whole picture / on its left half |
//! | L | lamp and sun on / off |
//! | H | text on / off |
//! | mouse | left: orbit, right: pan, wheel: zoom |
//! | Esc | quit |

mod args;
mod overlay;
mod room;
mod settings;

use bevy::{
    camera::{Exposure, Hdr},
    prelude::*,
    render::diagnostic::RenderDiagnosticsPlugin,
    ui::IsDefaultUiCamera,
};
use bevy_lean_deferred::prelude::*;
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use kit::{
    example::{made_up_sky::made_up_sky, model, run},
    headless::Headless,
};
use settings::ExampleSettings;

fn main() -> AppExit {
    let args: args::Args = argh::from_env();
    if let Err(message) = args.file.as_deref().map_or(Ok(()), model::check_file) {
        eprintln!("error: {message}");
        return AppExit::error();
    }
    let example = ExamplePlugin {
        settings: args.settings(),
        model: model::ModelPath(args.file.clone()),
        viewpoint: args.viewpoint(),
    };
    match &args.headless {
        Some(path) => {
            let headless = Headless::with(args.size, |app| {
                app.add_plugins(example);
                if args.text {
                    app.add_plugins(overlay::OverlayPlugin);
                }
            });
            run::write_picture(headless, path, args.frames)
        }
        None => run::windowed("bevy_lean_deferred screen space", args.size)
            .add_plugins((PanOrbitCameraPlugin, example, overlay::OverlayPlugin))
            .add_systems(Update, settings::read_keys)
            .run(),
    }
}

/// The scene, the camera and its effects.
struct ExamplePlugin {
    settings: ExampleSettings,
    model: model::ModelPath,
    viewpoint: model::Viewpoint,
}

impl Plugin for ExamplePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(RenderDiagnosticsPlugin)
            .insert_resource(self.settings.clone())
            .insert_resource(self.model.clone())
            .insert_resource(self.viewpoint)
            .add_systems(
                Startup,
                (
                    spawn_camera,
                    room::spawn_sun,
                    model::spawn_model,
                    (room::spawn, room::stand_camera).run_if(model::is_builtin),
                )
                    .chain(),
            )
            .add_systems(
                Update,
                (
                    model::watch_loading,
                    settings::apply.run_if(resource_changed::<ExampleSettings>),
                ),
            );
    }
}

fn spawn_camera(mut commands: Commands, mut images: ResMut<Assets<Image>>) {
    let sky = images.add(made_up_sky());
    commands.spawn((
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        IsDefaultUiCamera,
        LeanDeferred::default(),
        Exposure::OVERCAST,
        GeneratedEnvironmentMapLight {
            environment_map: sky,
            intensity: 1_500.0,
            ..default()
        },
        PanOrbitCamera {
            button_orbit: MouseButton::Left,
            button_pan: MouseButton::Right,
            ..default()
        },
        Transform::default(),
    ));
}
