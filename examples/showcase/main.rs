//! A street by night through everything the crate has: thousands of lights, neon, wet asphalt, people under umbrellas. Or
//! any glTF.
//!
//! `cargo run --example showcase -- [--model FILE | --figure FILE] [--headless OUT.png] [--help]`
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3 | Bevy forward, Bevy deferred, lean |
//! | O, G, R, S, E | occlusion, diffuse GI, reflections, subsurface scattering, auto exposure on / off (lean only) |
//! | V | next viewpoint of the street |
//! | P | people walk / stand |
//! | H | text on / off |
//! | mouse | left: orbit, right: pan, wheel: zoom |
//! | Esc | quit |
//!
//! `--headless` writes a picture split into Bevy forward and lean, and beside it one of each effect off and on. It also
//! prints the cost of each on this machine.

mod args;
mod companions;
mod effects;
mod overlay;
mod report;
mod scene;
mod settings;

use bevy::{prelude::*, render::diagnostic::RenderDiagnosticsPlugin};
use bevy_panorbit_camera::PanOrbitCameraPlugin;
use kit::{
    example::{model, run},
    gpu,
    headless::Headless,
};

fn main() -> AppExit {
    let args: args::Args = argh::from_env();
    let args = args.fill_in(gpu::is_there());
    for file in [&args.model, &args.figure].into_iter().flatten() {
        if let Err(message) = model::check_file(file) {
            eprintln!("error: {message}");
            return AppExit::error();
        }
    }
    let scene = scene::ScenePlugin {
        model: model::ModelPath(args.model.clone()),
        figure: args.figure.clone(),
        detail: args.detail,
    };
    match &args.headless {
        Some(path) => {
            let headless = Headless::with(args.size, |app| {
                app.add_plugins((scene, settings::SettingsPlugin::of_pictures()));
                report::prepare(app);
            });
            report::write(headless, path, args.frames)
        }
        None => run::windowed("bevy_lean_deferred showcase", args.size)
            .add_plugins((
                RenderDiagnosticsPlugin,
                PanOrbitCameraPlugin,
                scene,
                settings::SettingsPlugin::of_window(),
                overlay::OverlayPlugin,
            ))
            .run(),
    }
}
