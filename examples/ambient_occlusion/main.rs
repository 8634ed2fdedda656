//! Ambient occlusion in a courtyard (or any glTF or GLB file): none, this crate's, or Bevy's.
//!
//! `cargo run --example ambient_occlusion -- [FILE] [--headless OUT.png] [--help]`
//!
//! The keys 1, 2 and 3 choose none, `LeanScreenSpaceAmbientOcclusion` and Bevy's `ScreenSpaceAmbientOcclusion`; G inserts
//! `LeanDeferred` on the camera, and removes it. `docs/examples.md` lists the other keys. Mouse: left orbits, right pans, the wheel zooms.

mod courtyard;
mod errors;

use bevy::{
    camera::Hdr,
    core_pipeline::prepass::{DepthPrepass, NormalPrepass},
    pbr::ScreenSpaceAmbientOcclusion,
    prelude::*,
    ui::IsDefaultUiCamera,
};
use bevy_lean_deferred::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;
use kit::example::{
    choices,
    keys::{Technique, TechniquePlugin},
    model::{self, ModelPath, Viewpoint},
    numbers::{finite, positive},
    panel::{Panel, PanelCamera, panel},
    switch::switch,
};

kit::example_args! {
    /// A courtyard, or a glTF or GLB file, without ambient occlusion, with LeanScreenSpaceAmbientOcclusion, or with Bevy's.
    struct Args {
        /// the file to show; a courtyard when left out
        #[argh(positional)]
        file: Option<String>,

        /// off, lean (the default) or bevy
        #[argh(option, default = "Mode::Lean", from_str_fn(mode))]
        mode: Mode,

        /// direction of the camera in degrees, default 30
        #[argh(option, default = "30.0", from_str_fn(finite))]
        yaw: f32,

        /// height of the camera in degrees, default 15
        #[argh(option, default = "15.0", from_str_fn(finite))]
        pitch: f32,

        /// zoom factor of the camera, default 1
        #[argh(option, default = "1.0", from_str_fn(positive))]
        zoom: f32,
    }
}

/// The occlusion technique on the camera.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
enum Mode {
    Off,
    Lean,
    Bevy,
}

impl Technique for Mode {
    const CHOICES: [Self; 3] = [Self::Off, Self::Lean, Self::Bevy];

    fn title(self) -> &'static str {
        match self {
            Self::Off => "no ambient occlusion",
            Self::Lean => "LeanScreenSpaceAmbientOcclusion",
            Self::Bevy => "Bevy's ScreenSpaceAmbientOcclusion",
        }
    }
}

fn mode(text: &str) -> Result<Mode, String> {
    choices::parse(&Mode::CHOICES, text)
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    if let Err(message) = args.file.as_deref().map_or(Ok(()), model::check_file) {
        eprintln!("error: {message}");
        return AppExit::error();
    }
    let example = args.example("ambient occlusion", UVec2::new(1280, 720), 8);
    App::new()
        .add_plugins((
            example.set_up(DefaultPlugins),
            LeanDeferredPlugins,
            example,
            TechniquePlugin(args.mode),
            panel::<LeanScreenSpaceAmbientOcclusion>("LeanScreenSpaceAmbientOcclusion"),
            panel::<ScreenSpaceAmbientOcclusion>("Bevy's ScreenSpaceAmbientOcclusion"),
            panel::<LeanDeferred>("LeanDeferred"),
        ))
        .insert_resource(ModelPath(args.file))
        .insert_resource(Viewpoint::from_degrees(args.yaw, args.pitch, args.zoom))
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
                apply.run_if(resource_changed::<Mode>),
                write_head,
            ),
        )
        .run()
}

fn spawn_camera(mut commands: Commands) {
    commands.spawn((
        Camera3d::default(),
        LeanScreenSpaceAmbientOcclusion::default(),
        // LeanDeferred and both techniques need it; all modes have it, so that they compare.
        Hdr,
        Msaa::Off,
        PanelCamera,
        IsDefaultUiCamera,
        PanOrbitCamera {
            button_orbit: MouseButton::Left,
            button_pan: MouseButton::Right,
            ..default()
        },
        Transform::default(),
    ));
}

fn apply(mut commands: Commands, mode: Res<Mode>, camera: Single<Entity, With<PanelCamera>>) {
    let mut camera = commands.entity(*camera);
    switch::<LeanScreenSpaceAmbientOcclusion>(&mut camera, *mode == Mode::Lean);
    switch::<ScreenSpaceAmbientOcclusion>(&mut camera, *mode == Mode::Bevy);
    if *mode != Mode::Bevy {
        // They came with Bevy's component.
        camera.remove::<(DepthPrepass, NormalPrepass)>();
    }
}

fn write_head(
    mode: Res<Mode>,
    occlusion: Single<Option<&LeanScreenSpaceAmbientOcclusion>, With<PanelCamera>>,
    mut panel: ResMut<Panel>,
) {
    panel.head = errors::text(*mode, *occlusion);
}
