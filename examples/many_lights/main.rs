//! The scene of the benches, live: 1600 meshes under hundreds of moving point lights. The text keeps, for each renderer, its
//! last GPU time for the meshes and their lighting, with the number of lights.
//!
//! `cargo run --example many_lights -- [--lights N] [--headless OUT.png] [--help]`
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3 | Bevy forward, Bevy deferred, lean |
//! | Space | next renderer |
//! | Up, Down | twice / half as many lights |
//! | Esc | quit |

mod times;

use argh::FromArgs;
use bevy::{
    diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    light::cluster::GlobalClusterSettings,
    prelude::*,
    render::diagnostic::RenderDiagnosticsPlugin,
    ui::IsDefaultUiCamera,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    bench_spans,
    example::{
        choices::next,
        opaque_method::OpaqueMethod,
        run::{self, SceneReady},
        text_panel::{TextPanel, spawn_text_panel},
    },
    headless::Headless,
    renderer::Renderer,
    scenes::boxes::{self, Boxes},
};
use times::GpuTimes;

/// The scene of the benches, live.
#[derive(FromArgs)]
struct Args {
    /// point lights, default 512
    #[argh(option, default = "512")]
    lights: u32,

    /// a grid of 10 by 10 meshes in place of 40 by 40, for software renderers
    #[argh(switch)]
    small: bool,

    /// forward, deferred or lean (the default)
    #[argh(option, default = "Renderer::Lean")]
    renderer: Renderer,

    /// render without a window, write this PNG and quit
    #[argh(option)]
    headless: Option<String>,

    /// time the other renderers first, with --headless
    #[argh(switch)]
    compare: bool,
}

#[derive(Resource, Clone, Copy)]
struct Settings {
    boxes: Boxes,
    renderer: Renderer,
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    let boxes = if args.small {
        Boxes::small(args.lights)
    } else {
        Boxes::full(args.lights)
    };
    let settings = Settings {
        boxes,
        renderer: args.renderer,
    };
    match &args.headless {
        None => {
            let mut app = App::new();
            app.add_plugins((DefaultPlugins, LeanDeferredPlugins));
            add_scene(&mut app, settings);
            app.run()
        }
        Some(path) => {
            let mut headless = Headless::with(UVec2::new(1280, 720), |app| {
                add_scene(app, settings);
            });
            if args.compare
                && let Err(exit) = time_others(&mut headless, args.renderer)
            {
                return exit;
            }
            run::write_picture(headless, path, times::FRAMES)
        }
    }
}

/// Renders some frames with each renderer, with `chosen` last.
fn time_others(headless: &mut Headless, chosen: Renderer) -> Result<(), AppExit> {
    run::make_ready(headless)?;
    let others = Renderer::ALL.into_iter().filter(|other| *other != chosen);
    for renderer in others.chain([chosen]) {
        headless.world().resource_mut::<Settings>().renderer = renderer;
        headless.settle();
        headless.frames(times::FRAMES);
    }
    Ok(())
}

fn add_scene(app: &mut App, settings: Settings) {
    app.add_plugins((
        FrameTimeDiagnosticsPlugin::default(),
        RenderDiagnosticsPlugin,
    ))
    .insert_resource(settings)
    .insert_resource(SceneReady)
    .init_resource::<GpuTimes>()
    .add_systems(Startup, (setup, spawn_text_panel))
    .add_systems(
        Update,
        (
            read_keys,
            move_lights,
            apply_settings.run_if(resource_changed::<Settings>),
            times::measure,
            update_text,
        )
            .chain(),
    );
    bench_spans::add_bench_spans(app);
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    settings: Res<Settings>,
    mut clusters: ResMut<GlobalClusterSettings>,
) {
    boxes::reserve_clusters(&mut clusters);
    boxes::spawn(&mut commands, &mut meshes, &mut materials, settings.boxes);
    commands.spawn((
        Camera3d::default(),
        bevy::camera::Hdr,
        Msaa::Off,
        IsDefaultUiCamera,
        boxes::camera_transform(settings.boxes),
    ));
}

fn read_keys(
    keys: Option<Res<ButtonInput<KeyCode>>>,
    mut settings: ResMut<Settings>,
    mut exit: MessageWriter<AppExit>,
) {
    let Some(keys) = keys else {
        return;
    };
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::Digit1 => settings.renderer = Renderer::Forward,
            KeyCode::Digit2 => settings.renderer = Renderer::BevyDeferred,
            KeyCode::Digit3 => settings.renderer = Renderer::Lean,
            KeyCode::Space => settings.renderer = next(&Renderer::ALL, settings.renderer),
            KeyCode::ArrowUp => {
                settings.boxes.point_lights = (settings.boxes.point_lights * 2).clamp(1, 16_384);
            }
            KeyCode::ArrowDown => settings.boxes.point_lights /= 2,
            KeyCode::Escape => {
                exit.write(AppExit::Success);
            }
            _ => {}
        }
    }
}

fn apply_settings(
    mut commands: Commands,
    settings: Res<Settings>,
    camera: Single<Entity, With<Camera3d>>,
    lights: Query<Entity, With<PointLight>>,
    mut method: OpaqueMethod,
) {
    let mut camera = commands.entity(*camera);
    settings.renderer.prepare_camera(&mut camera);
    method.set(settings.renderer == Renderer::BevyDeferred);
    if lights.iter().len() != settings.boxes.point_lights as usize {
        for light in &lights {
            commands.entity(light).despawn();
        }
        boxes::spawn_point_lights(&mut commands, settings.boxes);
    }
}

/// Moves each light around the place where it was spawned.
fn move_lights(time: Res<Time>, mut lights: Query<&mut Transform, With<PointLight>>) {
    let step = time.delta_secs();
    let now = time.elapsed_secs();
    for (i, mut transform) in lights.iter_mut().enumerate() {
        let phase = i as f32 * 2.399;
        transform.translation.x += (now + phase).cos() * step;
        transform.translation.z += (now + phase).sin() * step;
    }
}

const EXPLANATION: &str =
    "GPU time to draw and light all meshes, from when each renderer was last on";
const KEYS: &str = "1 forward  2 deferred  3 lean  Space next  Up/Down lights  Esc quit";

fn update_text(
    settings: Res<Settings>,
    times: Res<GpuTimes>,
    diagnostics: Res<DiagnosticsStore>,
    mut text: Single<&mut Text, With<TextPanel>>,
) {
    let fps = diagnostics
        .get(&FrameTimeDiagnosticsPlugin::FPS)
        .and_then(|fps| fps.smoothed())
        .unwrap_or_default();
    text.0 = format!(
        "{} point lights, {fps:.0} frames a second\n{}{EXPLANATION}\n{KEYS}",
        settings.boxes.point_lights,
        times.table(settings.renderer),
    );
}
