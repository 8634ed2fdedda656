//! Shows any glTF or GLB file (or a built-in scene) through Bevy forward, Bevy deferred, or this crate.
//!
//! `cargo run --example viewer -- [FILE] [--headless OUT.png] [--help]`
//!
//! Drag a .gltf or .glb file onto the window to show it. If that fails, the old one stays, and the text says why. On Wayland
//! `winit` 0.30 reports no dropped files: unset `WAYLAND_DISPLAY`, to run under X11.
//!
//! The keys 1, 2 and 3 choose Bevy forward, Bevy deferred and lean; `docs/examples.md` lists the others. Mouse: left orbits, right
//! pans, the wheel zooms.

mod builtin;
mod sky;

use bevy::{camera::Hdr, prelude::*, ui::IsDefaultUiCamera};
use bevy_lean_deferred::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;
use kit::{
    example::{
        dropped_model::{DropMessage, DroppedModelPlugin},
        model::{self, ModelPath, Viewpoint},
        panel::{Panel, PanelCamera, fixed_panel, panel},
        renderers::RenderersPlugin,
        switch::Environment,
    },
    renderer::Renderer,
};
use sky::SkyFiles;

kit::example_args! {
    /// Shows a glTF or GLB file, or a built-in scene, through Bevy forward, Bevy deferred, or bevy_lean_deferred. Drag another file
    /// onto the window to show that.
    struct Args {
        /// the file to show; a built-in scene when left out
        #[argh(positional)]
        file: Option<String>,

        /// forward, deferred or lean (the default)
        #[argh(option, default = "Renderer::Lean")]
        renderer: Renderer,

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
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    let file = args.file.as_deref().map_or(Ok(()), model::check_file);
    let sky = match file.and_then(|()| SkyFiles::new(args.diffuse.clone(), args.specular.clone())) {
        Ok(sky) => sky,
        Err(message) => {
            eprintln!("error: {message}");
            return AppExit::error();
        }
    };
    let example = args.example("viewer", UVec2::new(1280, 720), 8);
    App::new()
        .add_plugins((
            example.set_up(DefaultPlugins),
            LeanDeferredPlugins,
            example,
            RenderersPlugin(args.renderer),
            panel::<LeanDeferred>("LeanDeferred"),
            fixed_panel::<Environment>("environment light"),
            DroppedModelPlugin,
        ))
        .insert_resource(ModelPath(args.file))
        .insert_resource(sky)
        .insert_resource(Viewpoint::from_degrees(args.yaw, args.pitch, 1.0))
        .add_systems(
            Startup,
            (
                spawn_camera,
                model::spawn_model,
                builtin::spawn.run_if(model::is_builtin),
                sky::spawn_sun,
            ),
        )
        .add_systems(Update, (model::watch_loading, sky::light, write_head))
        .run()
}

fn spawn_camera(mut commands: Commands) {
    commands.spawn((
        Camera3d::default(),
        LeanDeferred::default(),
        // LeanDeferred adds both; all renderers have them, so that they compare.
        Hdr,
        Msaa::Off,
        PanelCamera,
        Environment::default(),
        IsDefaultUiCamera,
        PanOrbitCamera {
            button_orbit: MouseButton::Left,
            button_pan: MouseButton::Right,
            ..default()
        },
        Transform::from_xyz(0.0, 1.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Writes the file, and why another one is not shown.
fn write_head(mut panel: ResMut<Panel>, model: Res<ModelPath>, drop: Res<DropMessage>) {
    let file = model.0.as_deref().unwrap_or("built-in scene");
    let message = drop.0.as_ref().map(|message| format!("\n> {message}"));
    panel.head = format!(
        "{file}, or drag another one here{}",
        message.unwrap_or_default()
    );
}
