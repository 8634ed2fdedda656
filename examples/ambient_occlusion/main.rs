//! Ambient occlusion in a courtyard (or any glTF or GLB file): none, this crate's, or Bevy's.
//!
//! `cargo run --example ambient_occlusion -- [FILE] [--headless OUT.png] [--help]`
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3 | none, `LeanScreenSpaceAmbientOcclusion`, Bevy's `ScreenSpaceAmbientOcclusion` |
//! | G | `LeanDeferred` on / off |
//! | P | next quality |
//! | K | kernel: HBAO, HDAO |
//! | A | application: Auto, MultiplicativeBlend, Indirect |
//! | D | occlusion alone / lit picture |
//! | B | occlusion alone on the whole picture / on its left half |
//! | Up, Down | larger, smaller radius |
//! | Right, Left | more, less intensity |
//! | R | full / half resolution |
//! | F | narrow / wide filter |
//! | E | filter ignores edges / averages across them |
//! | N | shading / geometric normals |
//! | L | sun on / off |
//! | H | text on / off |
//! | mouse | left: orbit, right: pan, wheel: zoom |
//! | Esc | quit |

mod args;
mod courtyard;
mod errors;
mod overlay;
mod settings;

use bevy::{
    camera::Hdr, prelude::*, render::diagnostic::RenderDiagnosticsPlugin, ui::IsDefaultUiCamera,
};
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use kit::{
    example::{model, run},
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
        None => run::windowed("bevy_lean_deferred ambient occlusion", args.size)
            .add_plugins((PanOrbitCameraPlugin, example, overlay::OverlayPlugin))
            .add_systems(Update, settings::read_keys)
            .run(),
    }
}

/// The scene, the camera and its ambient occlusion.
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
                    courtyard::spawn_lights,
                    model::spawn_model,
                    (courtyard::spawn, courtyard::stand_camera).run_if(model::is_builtin),
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

fn spawn_camera(mut commands: Commands) {
    commands.spawn((
        Camera3d::default(),
        // LeanDeferred and both techniques need it; all modes have it, so that they compare.
        Hdr,
        Msaa::Off,
        IsDefaultUiCamera,
        PanOrbitCamera {
            button_orbit: MouseButton::Left,
            button_pan: MouseButton::Right,
            ..default()
        },
        Transform::default(),
    ));
}
