//! A street by night through everything the crate has: thousands of lights, neon, wet asphalt, people under umbrellas. Or
//! any glTF.
//!
//! `cargo run --example showcase -- [--model FILE | --figure FILE] [--headless OUT.png] [--help]`
//!
//! The keys 1, 2 and 3 choose Bevy forward, Bevy deferred and lean. The panel switches each effect, moves the camera to the viewpoints
//! of the street, and lets people stand; `docs/examples.md` lists the other keys. Mouse: left orbits, right pans, the wheel zooms.
//!
//! `--headless` writes a picture split into Bevy forward and lean, and beside it one of each effect off and on. It also
//! prints the cost of each on this machine. With `--place` it writes one picture, with the effects of `--set`.

mod args;
mod companions;
mod effects;
mod report;
mod scene;
mod settings;

use bevy::{
    anti_alias::smaa::Smaa,
    camera::{Hdr, ShadowLodOrigin},
    post_process::bloom::Bloom,
    prelude::*,
    ui::IsDefaultUiCamera,
};
use bevy_lean_deferred::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;
use kit::{
    bench_spans::add_bench_spans,
    example::{
        model,
        panel::{Panel, PanelCamera, panel},
        renderers::RenderersPlugin,
        run::Example,
    },
    gpu,
    renderer::Renderer,
};
use settings::{Place, Street};

fn main() -> AppExit {
    let args: args::Args = argh::from_env();
    let args = args.fill_in(gpu::is_there());
    for file in [&args.model, &args.figure].into_iter().flatten() {
        if let Err(message) = model::check_file(file) {
            eprintln!("error: {message}");
            return AppExit::error();
        }
    }
    let is_windowed = args.headless.is_none();
    let (frames, place) = (args.frames, args.place);
    let example = Example {
        title: "showcase",
        size: args.size,
        headless: args.headless,
        set: args.set,
        ..Example::with_frames(frames)
    };
    let example = match place {
        Some(_) => example,
        None => example.written_by(move |headless, path| report::write(headless, path, frames)),
    };
    let mut app = App::new();
    app.add_plugins((
        example.set_up(DefaultPlugins),
        LeanDeferredPlugins,
        example,
        // The report begins with the reference.
        RenderersPlugin(match is_windowed || place.is_some() {
            true => args.renderer,
            false => Renderer::Forward,
        }),
        scene::ScenePlugin {
            model: model::ModelPath(args.model),
            figure: args.figure,
            detail: args.detail,
        },
        panel::<LeanScreenSpaceAmbientOcclusion>("LeanScreenSpaceAmbientOcclusion"),
        panel::<LeanScreenSpaceGi>("LeanScreenSpaceGi"),
        panel::<LeanScreenSpaceReflections>("LeanScreenSpaceReflections"),
        panel::<LeanSubsurfaceScattering>("LeanSubsurfaceScattering"),
        panel::<LeanAutoExposure>("LeanAutoExposure"),
    ))
    .add_systems(PreStartup, move |commands: Commands| {
        spawn_camera(commands, is_windowed, place.unwrap_or_default());
    })
    .add_systems(Update, write_head);
    if !is_windowed {
        add_bench_spans(&mut app);
    }
    app.run()
}

/// Spawns a camera with all effects but ambient occlusion, which GI replaces. Pictures begin without effects, and nobody walks in them.
fn spawn_camera(mut commands: Commands, is_windowed: bool, place: Place) {
    let mut camera = commands.spawn((
        Camera3d::default(),
        LeanDeferred::default(),
        Hdr,
        Msaa::Off,
        Smaa::default(),
        Bloom::NATURAL,
        PanelCamera,
        Street {
            walk: is_windowed,
            place,
        },
        IsDefaultUiCamera,
        // Named because the camera of a picture renders to no window, of which Bevy warns.
        ShadowLodOrigin,
        PanOrbitCamera {
            button_orbit: MouseButton::Left,
            button_pan: MouseButton::Right,
            ..default()
        },
        Transform::default(),
    ));
    if is_windowed {
        camera.insert((
            LeanScreenSpaceGi::default(),
            LeanScreenSpaceReflections::default(),
            LeanSubsurfaceScattering::default(),
            effects::night_exposure(),
        ));
    }
}

/// Writes the number of lights.
fn write_head(
    lights: Query<(), Or<(With<PointLight>, With<SpotLight>)>>,
    mut panel: ResMut<Panel>,
) {
    panel.head = format!("{} point and spot lights", lights.iter().count());
}
