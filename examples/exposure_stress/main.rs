//! Frames per second with auto exposure on many cameras: the boxes scene of the benches, or a sky alone, in one viewport per
//! camera, as fast as possible.
//!
//! `cargo run --example exposure_stress -- [--cameras N] [--effect none|lean|bevy] [--headless] [--help]`
//!
//! In a window, without vertical synchronisation, frame times are those of the whole app, printed every three seconds and at
//! the end. With `--headless` the CPU waits for the GPU after each frame, so that frame times are the sum of both. Compare
//! `--effect none` with the others. The keys 1, 2 and 3 choose none, `LeanAutoExposure` and Bevy's `AutoExposure`; Esc quits.

mod args;

use core::f32::consts::TAU;
use kit::{
    example::{
        frame_times::{FrameReports, FrameTimes},
        gpu_times,
        keys::{TechniquePlugin, read_keys},
        made_up_sky::made_up_sky,
        panel::PanelCamera,
        run::{self, SceneReady},
        set,
        switch::switch,
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
        .add_systems(Update, (read_keys, measure))
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
    let effect = args.effect;
    for _ in 0..args.frames {
        let start = Instant::now();
        headless.frames(1);
        let recent = reports.add(start.elapsed().as_secs_f64() * 1000.0);
        if let Some(times) = recent {
            report("", &args, effect, &times, headless.app.world().resource());
        }
    }
    report(
        "all: ",
        &args,
        effect,
        &reports.all,
        headless.app.world().resource(),
    );
    AppExit::Success
}

fn add_scene(app: &mut App, args: Args) {
    let settings = args.set.clone();
    app.add_plugins((
        RenderDiagnosticsPlugin,
        AutoExposurePlugin,
        TechniquePlugin(args.effect),
    ))
    .insert_resource(args)
    .insert_resource(SceneReady)
    .add_systems(Startup, setup)
    .add_systems(PostStartup, move |world: &mut World| {
        set::apply_all(world, &settings);
    })
    .add_systems(
        Update,
        (
            turn_cameras,
            apply_effect.run_if(resource_changed::<Effect>),
        ),
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
            PanelCamera,
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
    }
}

/// Turns the cameras around the middle of the scene, so that the exposure keeps adapting.
fn turn_cameras(time: Res<Time>, mut cameras: Query<&mut Transform, With<Camera3d>>) {
    let turn = Quat::from_rotation_y(0.2 * time.delta_secs());
    for mut transform in &mut cameras {
        transform.rotate_around(Vec3::ZERO, turn);
    }
}

fn apply_effect(
    mut commands: Commands,
    effect: Res<Effect>,
    cameras: Query<Entity, With<Camera3d>>,
    reports: Option<ResMut<Reports>>,
) {
    for camera in &cameras {
        let mut camera = commands.entity(camera);
        switch::<LeanAutoExposure>(&mut camera, *effect == Effect::Lean);
        switch::<AutoExposure>(&mut camera, *effect == Effect::Bevy);
    }
    // Drops the times of the effect before.
    if let Some(mut reports) = reports {
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
    effect: Res<Effect>,
    diagnostics: Res<DiagnosticsStore>,
    mut reports: ResMut<Reports>,
) {
    reports.frames += 1;
    if reports.frames <= WARM_UP_FRAMES {
        return;
    }
    let recent = reports.times.add(time.delta_secs_f64() * 1000.0);
    if let Some(times) = recent {
        report("", &args, *effect, &times, &diagnostics);
    }
}

fn report_all(
    args: Res<Args>,
    effect: Res<Effect>,
    diagnostics: Res<DiagnosticsStore>,
    reports: Res<Reports>,
) {
    report("all: ", &args, *effect, &reports.times.all, &diagnostics);
}

/// Prints one line: the scene and effect, the frame times, and the effect's GPU times per camera.
fn report(
    what: &str,
    args: &Args,
    effect: Effect,
    times: &FrameTimes,
    diagnostics: &DiagnosticsStore,
) {
    let time = |span| gpu_times::text(diagnostics, span);
    let gpu = match effect {
        Effect::None => String::new(),
        Effect::Lean => format!("; GPU: {}", time("lean_deferred/effects/auto_exposure")),
        Effect::Bevy => format!("; GPU: auto_exposure {}", time("auto_exposure")),
    };
    println!(
        "{what}{effect:?}, cameras: {}, {}×{}: {times}{gpu}",
        args.cameras, args.size.x, args.size.y
    );
}
