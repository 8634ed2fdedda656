//! Auto exposure in a house with an open door: none, this crate's, or Bevy's.
//!
//! `cargo run --example auto_exposure -- [--view dark|room|door] [--headless OUT.png] [--help]`
//!
//! The sunshine outside is several thousand times brighter than the corner with the lamp. The panel moves the camera from one
//! to the other: the picture is too dark or too bright at first, and adapts. Where the camera sees both door and corner, the
//! metering and its pattern decide which of the two is exposed well.
//!
//! The mask of the example gives full weight to the lower half of the picture, and fades to a tenth at the top, so that
//! skies and ceilings count little:
//!
//! | height | weight |
//! |---|---|
//! | top | 0.1 |
//! | a quarter down | 0.55 |
//! | middle to bottom | 1 |
//!
//! The keys 1, 2 and 3 choose none, `LeanAutoExposure` and Bevy's `AutoExposure`, which gets the same settings where it has an
//! equivalent. Target and compensation become its compensation curve, and its range replaces the limits of the exposure.
//! `docs/examples.md` lists the other keys. Mouse: left looks around, right pans, the wheel moves.

mod garden;
mod house;
mod settings;
mod walk;

use bevy::{
    camera::{Exposure, Hdr, ShadowLodOrigin},
    core_pipeline::tonemapping::Tonemapping,
    ecs::system::RunSystemOnce,
    post_process::auto_exposure::{AutoExposure, AutoExposurePlugin},
    prelude::*,
    ui::IsDefaultUiCamera,
};
use bevy_lean_deferred::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;
use kit::{
    example::{
        choices,
        keys::{Technique, TechniquePlugin},
        panel::{Panel, PanelCamera, fixed_panel, panel},
        run::{self, SceneReady},
    },
    headless::Headless,
};
use settings::{House, Mode};
use walk::Place;

/// Between indoors and an overcast day, so that the exposures of both ends of the scene are within its limits.
const EXPOSURE: Exposure = Exposure { ev100: 8.0 };

/// Frames of 1/60 s before the picture, for effects that adapt at once.
const FRAMES: usize = 8;
/// Frames before the picture, for Bevy's effect, which starts without exposure: 8 simulated seconds.
const BEVY_FRAMES: usize = 480;

kit::example_args! {
    /// A house with an open door, without auto exposure, with LeanAutoExposure, or with Bevy's.
    struct Args {
        /// off, lean (the default) or bevy
        #[argh(option, default = "Mode::Lean", from_str_fn(mode))]
        mode: Mode,

        /// viewpoint: dark (the default), room or door
        #[argh(option, default = "Place::Dark", from_str_fn(place))]
        view: Place,

        /// viewpoint to start at, with --headless, so that the picture shows the exposure on its way
        #[argh(option, from_str_fn(place))]
        from: Option<Place>,
    }
}

fn mode(text: &str) -> Result<Mode, String> {
    choices::parse(&Mode::CHOICES, text)
}

fn place(text: &str) -> Result<Place, String> {
    choices::parse(&walk::PLACES, text)
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    let (view, is_windowed) = (args.view, args.headless.is_none());
    let start = args.from.filter(|_| !is_windowed).unwrap_or(view);
    let frames = match args.mode {
        Mode::Bevy => BEVY_FRAMES,
        Mode::Off | Mode::Lean => FRAMES,
    };
    let written_after = args.frames.unwrap_or(frames);
    let example = args
        .example("auto exposure", UVec2::new(1280, 720), frames)
        .written_by(move |headless, path| write_picture(headless, path, view, written_after));
    App::new()
        .add_plugins((
            example.set_up(DefaultPlugins),
            LeanDeferredPlugins,
            AutoExposurePlugin,
            example,
            TechniquePlugin(args.mode),
            fixed_panel::<House>("house"),
            panel::<LeanAutoExposure>("LeanAutoExposure"),
            panel::<AutoExposure>("Bevy's AutoExposure"),
            panel::<CameraCut>("CameraCut"),
            panel::<LeanDeferred>("LeanDeferred"),
        ))
        // The panel makes a `MeteringPattern::Mask` of a default handle, which `settings::complete` replaces.
        .register_type_data::<Handle<Image>, ReflectDefault>()
        .insert_resource(SceneReady)
        .add_systems(
            Startup,
            (
                (
                    move |commands: Commands| spawn_camera(commands, start),
                    settings::add_mask,
                ),
                (
                    house::spawn,
                    garden::spawn,
                    garden::spawn_lights,
                    walk::stand,
                ),
            )
                .chain(),
        )
        .add_systems(
            Update,
            (
                (
                    settings::complete,
                    settings::apply.run_if(resource_changed::<Mode>),
                )
                    .chain(),
                (walk::set_off, walk::walk)
                    .chain()
                    .run_if(move || is_windowed),
                write_head,
            ),
        )
        .run()
}

fn spawn_camera(mut commands: Commands, place: Place) {
    commands.spawn((
        Camera3d::default(),
        LeanAutoExposure::default(),
        MeteredExposure::default(),
        Projection::Perspective(PerspectiveProjection {
            fov: 1.0,
            ..default()
        }),
        // LeanDeferred and both auto exposures need it; all modes have it, so that they compare.
        Hdr,
        Msaa::Off,
        EXPOSURE,
        // Not `None`: tonemapping applies the exposure.
        Tonemapping::TonyMcMapface,
        PanelCamera,
        House { place, ..default() },
        IsDefaultUiCamera,
        ShadowLodOrigin,
        PanOrbitCamera {
            button_orbit: MouseButton::Left,
            button_pan: MouseButton::Right,
            ..default()
        },
        Transform::default(),
    ));
}

/// Writes a PNG, and prints its metered exposure.
fn write_picture(mut headless: Headless, path: &str, view: Place, frames: usize) -> AppExit {
    if let Err(exit) = run::make_ready(&mut headless) {
        return exit;
    }
    let world = headless.world();
    let mut houses = world.query::<&mut House>();
    for mut house in houses.iter_mut(world) {
        house.place = view;
    }
    if let Err(error) = world.run_system_once(walk::stand) {
        error!("{error}");
    }
    headless.frames(frames);
    let exit = run::save_picture(&mut headless, path);
    let world = headless.world();
    let mut metered = world.query_filtered::<&MeteredExposure, With<LeanAutoExposure>>();
    for exposure in metered.iter(world) {
        println!("{view:?}: {}", metered_text(exposure));
    }
    exit
}

/// The metered values that were read back.
fn metered_text(metered: &MeteredExposure) -> String {
    let MeteredExposure {
        luminance,
        exposure,
        target_exposure,
    } = metered;
    format!(
        "luminance {luminance:.4}, exposure {exposure:+.2} stops, heading for {target_exposure:+.2}"
    )
}

fn write_head(metered: Query<&MeteredExposure, With<LeanAutoExposure>>, mut panel: ResMut<Panel>) {
    panel.head = metered.iter().map(metered_text).collect();
}
