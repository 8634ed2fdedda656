//! Balls of every shading model and parameter that the G-buffer carries: lean beside forward.
//!
//! `cargo run --example materials -- [--headless OUT.png] [--help]`
//!
//! Each has a row; `rows.rs` lists them from top to bottom. Both halves show the same scene from the same place.
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3 | lean beside forward, lean alone, forward alone |
//! | D | next debug view of the G-buffer or of light, where lean is shown |
//! | B | debug view on the whole picture / on its left half |
//! | L | sun on / off |
//! | E | environment map on / off |
//! | S | subsurface scattering on / off, where lean is shown: forward has none |
//! | H | text on / off |
//! | mouse, over the left half | left: orbit, right: pan, wheel: zoom |
//! | Esc | quit |
//!
//! `--headless` writes a PNG. With lean beside forward it also prints the differences between the halves.

mod args;
mod figures;
mod grid;
mod overlay;
mod rows;
mod settings;

use bevy::{prelude::*, render::diagnostic::RenderDiagnosticsPlugin, window::WindowResized};
use bevy_panorbit_camera::PanOrbitCameraPlugin;
use kit::{example::run, headless::Headless};
use settings::ExampleSettings;

fn main() -> AppExit {
    let args: args::Args = argh::from_env();
    let example = ExamplePlugin {
        settings: args.settings(),
    };
    match &args.headless {
        Some(path) => {
            let headless = Headless::with(args.size, |app| {
                app.add_plugins(example);
                if args.text {
                    app.add_plugins(overlay::OverlayPlugin);
                }
            });
            figures::write_pictures(headless, path, &args)
        }
        None => run::windowed("bevy_lean_deferred materials", args.size)
            .add_plugins((PanOrbitCameraPlugin, example, overlay::OverlayPlugin))
            .add_systems(Update, settings::read_keys.before(settings::apply))
            .run(),
    }
}

/// The scene and its two cameras.
struct ExamplePlugin {
    settings: ExampleSettings,
}

impl Plugin for ExamplePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(RenderDiagnosticsPlugin)
            .insert_resource(self.settings.clone())
            .add_systems(
                Startup,
                (grid::spawn, grid::spawn_lights, settings::spawn_cameras),
            )
            .add_systems(
                Update,
                settings::apply.run_if(
                    resource_changed::<ExampleSettings>.or_else(on_message::<WindowResized>),
                ),
            )
            .add_systems(PostUpdate, settings::follow)
            .insert_resource(run::SceneReady);
    }
}
