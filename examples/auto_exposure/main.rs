//! Auto exposure in a house with an open door: none, this crate's, or Bevy's.
//!
//! `cargo run --example auto_exposure -- [--view dark|room|door] [--headless OUT.png] [--help]`
//!
//! The sunshine outside is several thousand times brighter than the corner with the lamp. Space moves the camera from one
//! to the other and back: the picture is too dark or too bright at first, and adapts. Where the camera sees both door and
//! corner, the metering and its pattern decide which of the two is exposed well.
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
//! Bevy's `AutoExposure` gets the same settings where it has an equivalent. Target and compensation become its compensation
//! curve, and its range replaces the limits of the exposure.
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3 | none, `LeanAutoExposure`, Bevy's `AutoExposure` |
//! | Space | next place: dark corner, middle of the room, door, and back |
//! | G | `LeanDeferred` on / off |
//! | M | metering: LogAverage, LinearAverage |
//! | P | pattern: Average, CenterWeighted, Spot, Mask |
//! | T | trim: leave out the darkest and the brightest tenth / none |
//! | Up, Down | larger, smaller target |
//! | Right, Left | more, less compensation |
//! | C | compensation curve on / off |
//! | Page Up, Page Down | twice, half the speeds |
//! | I | instant / adapting |
//! | R | reduction: Auto, Subgroup, SharedMemory |
//! | X | cut: the next frame starts adapted |
//! | D | weights of pixels and a scale of the exposure on / off |
//! | B | these on the whole picture / on its left half |
//! | H | text on / off |
//! | mouse | left: look around, right: pan, wheel: move |
//! | Esc | quit |

mod args;
mod garden;
mod house;
mod overlay;
mod settings;
mod walk;

use bevy::{
    camera::{Exposure, Hdr, ShadowLodOrigin},
    core_pipeline::tonemapping::Tonemapping,
    ecs::system::RunSystemOnce,
    post_process::auto_exposure::AutoExposurePlugin,
    prelude::*,
    render::diagnostic::RenderDiagnosticsPlugin,
    ui::IsDefaultUiCamera,
};
use bevy_lean_deferred::prelude::*;
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use kit::{example::run, headless::Headless};
use settings::ExampleSettings;
use walk::Place;

/// Between indoors and an overcast day, so that the exposures of both ends of the scene are within its limits.
const EXPOSURE: Exposure = Exposure { ev100: 8.0 };

fn main() -> AppExit {
    let args: args::Args = argh::from_env();
    let example = ExamplePlugin {
        settings: args.settings(),
        place: args.start(),
    };
    match &args.headless {
        Some(path) => {
            let headless = Headless::with(args.size, |app| {
                app.add_plugins(example);
                if args.text {
                    app.add_plugins(overlay::OverlayPlugin);
                }
            });
            write_picture(headless, path, &args)
        }
        None => run::windowed("bevy_lean_deferred auto exposure", args.size)
            .add_plugins((PanOrbitCameraPlugin, example, overlay::OverlayPlugin))
            .add_systems(
                Update,
                (
                    settings::read_keys.before(settings::apply),
                    (walk::read_keys, walk::walk).chain(),
                ),
            )
            .run(),
    }
}

/// Writes a PNG, and prints its metered exposure.
fn write_picture(mut headless: Headless, path: &str, args: &args::Args) -> AppExit {
    if let Err(exit) = run::make_ready(&mut headless) {
        return exit;
    }
    let world = headless.world();
    if *world.resource::<Place>() != args.view {
        world.insert_resource(args.view);
        if let Err(error) = world.run_system_once(walk::stand) {
            error!("{error}");
        }
    }
    headless.frames(args.frames());
    let exit = run::save_picture(&mut headless, path);
    let world = headless.world();
    let mut metered = world.query_filtered::<&MeteredExposure, With<LeanAutoExposure>>();
    for metered in metered.iter(world) {
        println!("{:?}: {}", args.view, overlay::metered(metered));
    }
    exit
}

/// The scene, the camera and its auto exposure.
struct ExamplePlugin {
    settings: ExampleSettings,
    place: Place,
}

impl Plugin for ExamplePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((RenderDiagnosticsPlugin, AutoExposurePlugin))
            .insert_resource(self.settings.clone())
            .insert_resource(self.place)
            .add_systems(
                Startup,
                (
                    (spawn_camera, settings::add_mask),
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
                settings::apply.run_if(resource_changed::<ExampleSettings>),
            )
            .insert_resource(run::SceneReady);
    }
}

fn spawn_camera(mut commands: Commands) {
    commands.spawn((
        Camera3d::default(),
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
