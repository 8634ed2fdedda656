//! The scene of the benches, live: 1600 meshes under hundreds of moving point lights.
//!
//! `cargo run --example many_lights -- [--lights N] [--headless OUT.png] [--help]`
//!
//! | key | does |
//! |---|---|
//! | Space | lean on / off |
//! | Up, Down | twice / half as many lights |
//! | Esc | quit |

use argh::FromArgs;
use bevy::{
    diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    light::cluster::GlobalClusterSettings,
    prelude::*,
    render::diagnostic::RenderDiagnosticsPlugin,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    example::{
        gpu_times,
        run::{self, SceneReady},
    },
    headless::Headless,
    scenes::boxes::{self, Boxes},
};

/// The scene of the benches, live.
#[derive(FromArgs)]
struct Args {
    /// point lights, default 512
    #[argh(option, default = "512")]
    lights: u32,

    /// a grid of 10 by 10 meshes in place of 40 by 40, for software renderers
    #[argh(switch)]
    small: bool,

    /// render without a window, write this PNG and quit
    #[argh(option)]
    headless: Option<String>,
}

#[derive(Resource, Clone, Copy)]
struct Settings {
    boxes: Boxes,
    lean: bool,
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    let boxes = if args.small {
        Boxes::small(args.lights)
    } else {
        Boxes::full(args.lights)
    };
    let settings = Settings { boxes, lean: true };
    match &args.headless {
        None => {
            let mut app = App::new();
            app.add_plugins((DefaultPlugins, LeanDeferredPlugins));
            add_scene(&mut app, settings);
            app.run()
        }
        Some(path) => {
            let headless = Headless::with(UVec2::new(1280, 720), |app| {
                add_scene(app, settings);
            });
            run::write_picture(headless, path, 0)
        }
    }
}

fn add_scene(app: &mut App, settings: Settings) {
    app.add_plugins((
        FrameTimeDiagnosticsPlugin::default(),
        RenderDiagnosticsPlugin,
    ))
    .insert_resource(settings)
    .insert_resource(SceneReady)
    .add_systems(Startup, setup)
    .add_systems(
        Update,
        (read_keys, move_lights, apply_settings, update_text).chain(),
    );
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
        boxes::camera_transform(settings.boxes),
    ));
    commands.spawn((
        Text::default(),
        Node {
            position_type: PositionType::Absolute,
            top: px(8),
            left: px(10),
            ..default()
        },
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
    if keys.just_pressed(KeyCode::Space) {
        settings.lean = !settings.lean;
    }
    if keys.just_pressed(KeyCode::ArrowUp) {
        settings.boxes.point_lights = (settings.boxes.point_lights * 2).clamp(1, 16_384);
    }
    if keys.just_pressed(KeyCode::ArrowDown) {
        settings.boxes.point_lights /= 2;
    }
    if keys.just_pressed(KeyCode::Escape) {
        exit.write(AppExit::Success);
    }
}

fn apply_settings(
    mut commands: Commands,
    settings: Res<Settings>,
    camera: Single<Entity, With<Camera3d>>,
    lights: Query<Entity, With<PointLight>>,
) {
    if !settings.is_changed() {
        return;
    }
    let mut camera = commands.entity(*camera);
    if settings.lean {
        camera.insert(LeanDeferred::default());
    } else {
        camera.remove::<LeanDeferred>();
    }
    if lights.iter().len() != settings.boxes.point_lights as usize {
        for light in &lights {
            commands.entity(light).despawn();
        }
        boxes::spawn_point_lights(&mut commands, settings.boxes);
    }
}

/// Each light goes round where it was spawned.
fn move_lights(time: Res<Time>, mut lights: Query<&mut Transform, With<PointLight>>) {
    let step = time.delta_secs();
    let now = time.elapsed_secs();
    for (i, mut transform) in lights.iter_mut().enumerate() {
        let phase = i as f32 * 2.399;
        transform.translation.x += (now + phase).cos() * step;
        transform.translation.z += (now + phase).sin() * step;
    }
}

fn update_text(
    settings: Res<Settings>,
    diagnostics: Res<DiagnosticsStore>,
    mut text: Single<&mut Text>,
) {
    let fps = diagnostics
        .get(&FrameTimeDiagnosticsPlugin::FPS)
        .and_then(|fps| fps.smoothed())
        .unwrap_or_default();
    let gpu = |name| gpu_times::text(&diagnostics, name);
    text.0 = format!(
        "{} lights, {} (Space), {fps:.0} frames a second\nG-buffer {}, lighting {}, opaque {}",
        settings.boxes.point_lights,
        if settings.lean {
            "lean"
        } else {
            "Bevy forward"
        },
        gpu("lean_deferred/gbuffer"),
        gpu("lean_deferred/lighting"),
        gpu("main_opaque_pass_3d"),
    );
}
