//! Frames per second with auto exposure on many cameras: the boxes scene of the benches, or a sky alone, in one viewport per
//! camera, as fast as possible.
//!
//! `cargo run --example exposure_stress -- [--cameras N] [--effect none|lean|bevy] [--headless] [--help]`
//!
//! In a window, without vertical synchronisation, frame times are those of the whole app, printed every three seconds and at
//! the end. With `--headless` the CPU waits for the GPU after each frame, so that frame times are the sum of both. Compare
//! `--effect none` with the others.
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3 | none, `LeanAutoExposure`, Bevy's `AutoExposure` |
//! | Esc | quit |

mod args;

use core::f32::consts::TAU;
use kit::{
    example::{
        frame_times::{FrameReports, FrameTimes},
        gpu_times,
        made_up_sky::made_up_sky,
        run::{self, SceneReady},
    },
    headless::Headless,
    scenes::boxes,
};
use std::time::Instant;

use args::{Args, Effect};
use bevy::{
    camera::{Hdr, ShadowLodOrigin},
    core_pipeline::tonemapping::Tonemapping,
    diagnostic::DiagnosticsStore,
    light::{Skybox, cluster::GlobalClusterSettings},
    post_process::auto_exposure::{AutoExposure, AutoExposurePlugin},
    prelude::*,
    render::diagnostic::RenderDiagnosticsPlugin,
    window::{PresentMode, WindowResolution},
    winit::WinitSettings,
};
use bevy_lean_deferred::prelude::*;

/// Frames before measuring: pipelines compile, and shadow maps are created.
const WARM_UP_FRAMES: usize = 20;

fn main() -> AppExit {
    let args: Args = argh::from_env();
    let UVec2 { x, y } = args.size;
    if args.grid().cmpgt(args.size).any() {
        eprintln!("error: {} viewports do not fit in {x}×{y}", args.cameras);
        return AppExit::error();
    }
    if args.headless {
        run_headless(args)
    } else {
        let mut app = App::new();
        app.add_plugins((
            DefaultPlugins.set(WindowPlugin {
                primary_window: Some(Window {
                    title: "bevy_lean_deferred exposure stress".into(),
                    present_mode: PresentMode::AutoNoVsync,
                    resolution: WindowResolution::new(x, y).with_scale_factor_override(1.0),
                    resizable: false,
                    ..default()
                }),
                ..default()
            }),
            LeanDeferredPlugins,
        ))
        .insert_resource(WinitSettings::continuous())
        .init_resource::<Reports>()
        .add_systems(Update, (read_keys.before(apply_effect), measure))
        .add_systems(Last, report_all.run_if(on_message::<AppExit>));
        add_scene(&mut app, args);
        app.run()
    }
}

fn run_headless(args: Args) -> AppExit {
    let mut headless = Headless::with(args.size, |app| add_scene(app, args.clone()));
    if let Err(exit) = run::make_ready(&mut headless) {
        return exit;
    }
    headless.frames(WARM_UP_FRAMES);
    let mut reports = FrameReports::default();
    for _ in 0..args.frames {
        let start = Instant::now();
        headless.frames(1);
        let recent = reports.add(start.elapsed().as_secs_f64() * 1000.0);
        if let Some(times) = recent {
            report("", &args, &times, headless.app.world().resource());
        }
    }
    report(
        "all: ",
        &args,
        &reports.all,
        headless.app.world().resource(),
    );
    AppExit::Success
}

fn add_scene(app: &mut App, args: Args) {
    app.add_plugins((RenderDiagnosticsPlugin, AutoExposurePlugin))
        .insert_resource(args)
        .insert_resource(SceneReady)
        .add_systems(Startup, setup)
        .add_systems(
            Update,
            (turn_cameras, apply_effect.run_if(resource_changed::<Args>)),
        );
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    args: Res<Args>,
    mut images: ResMut<Assets<Image>>,
    mut clusters: ResMut<GlobalClusterSettings>,
) {
    let sky = args.sky.then(|| Skybox {
        image: Some(images.add(made_up_sky())),
        brightness: 1_000.0,
        ..default()
    });
    if !args.sky {
        boxes::reserve_clusters(&mut clusters);
        boxes::spawn(&mut commands, &mut meshes, &mut materials, args.boxes());
    }
    for number in 0..args.cameras {
        let turn = Quat::from_rotation_y(TAU * number as f32 / args.cameras as f32);
        let mut camera = commands.spawn((
            Camera3d::default(),
            Camera {
                order: number as isize,
                viewport: Some(args.viewport(number)),
                ..default()
            },
            Hdr,
            Msaa::Off,
            Tonemapping::TonyMcMapface,
            Transform::from_rotation(turn) * boxes::camera_transform(args.boxes()),
        ));
        if number == 0 {
            camera.insert(ShadowLodOrigin);
        }
        if let Some(sky) = &sky {
            camera.insert(sky.clone());
        }
        if args.deferred {
            camera.insert(LeanDeferred::default());
        }
    }
}

/// Turns the cameras around the middle of the scene, so that the exposure keeps adapting.
fn turn_cameras(time: Res<Time>, mut cameras: Query<&mut Transform, With<Camera3d>>) {
    let turn = Quat::from_rotation_y(0.2 * time.delta_secs());
    for mut transform in &mut cameras {
        transform.rotate_around(Vec3::ZERO, turn);
    }
}

fn apply_effect(mut commands: Commands, args: Res<Args>, cameras: Query<Entity, With<Camera3d>>) {
    for camera in &cameras {
        let mut camera = commands.entity(camera);
        camera.remove::<(LeanAutoExposure, AutoExposure)>();
        match args.effect {
            Effect::None => {}
            Effect::Lean => {
                camera.insert(args.lean());
            }
            Effect::Bevy => {
                camera.insert(AutoExposure::default());
            }
        }
    }
}

fn read_keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut args: ResMut<Args>,
    mut reports: ResMut<Reports>,
    mut exit: MessageWriter<AppExit>,
) {
    for key in keys.get_just_pressed() {
        args.effect = match key {
            KeyCode::Digit1 => Effect::None,
            KeyCode::Digit2 => Effect::Lean,
            KeyCode::Digit3 => Effect::Bevy,
            KeyCode::Escape => {
                exit.write(AppExit::Success);
                continue;
            }
            _ => continue,
        };
        // Drops the times of the effect before.
        *reports = default();
    }
}

/// Frame times in a window.
#[derive(Resource, Default)]
struct Reports {
    frames: usize,
    times: FrameReports,
}

fn measure(
    time: Res<Time<Real>>,
    args: Res<Args>,
    diagnostics: Res<DiagnosticsStore>,
    mut reports: ResMut<Reports>,
) {
    reports.frames += 1;
    if reports.frames <= WARM_UP_FRAMES {
        return;
    }
    let recent = reports.times.add(time.delta_secs_f64() * 1000.0);
    if let Some(times) = recent {
        report("", &args, &times, &diagnostics);
    }
}

fn report_all(args: Res<Args>, diagnostics: Res<DiagnosticsStore>, reports: Res<Reports>) {
    report("all: ", &args, &reports.times.all, &diagnostics);
}

/// Prints one line: the scene and effect, the frame times, and the effect's GPU times per camera.
fn report(what: &str, args: &Args, times: &FrameTimes, diagnostics: &DiagnosticsStore) {
    let time = |span| gpu_times::text(diagnostics, span);
    let gpu = match args.effect {
        Effect::None => String::new(),
        Effect::Lean => format!("; GPU: {}", time("lean_deferred/effects/auto_exposure")),
        Effect::Bevy => format!("; GPU: auto_exposure {}", time("auto_exposure")),
    };
    println!(
        "{what}{:?}, cameras: {}, {}×{}: {times}{gpu}",
        args.effect, args.cameras, args.size.x, args.size.y
    );
}
