//! A loading screen: `LeanPrewarm` compiles what the level will show, with a progress bar. Then lights, materials and fog appear one after
//! the other, and a text has the longest frame since.
//!
//! `cargo run --example prewarm -- [--without] [--headless OUT.png] [--help]`

use argh::FromArgs;
use bevy::{prelude::*, ui::IsDefaultUiCamera};
use bevy_lean_deferred::{LeanPrewarm, PrewarmFeatures, prelude::*};
use kit::{
    example::run::{self, SceneReady},
    headless::Headless,
};

/// A loading screen with a progress bar.
#[derive(FromArgs)]
struct Args {
    /// begin at once, and compile what appears when it appears
    #[argh(switch)]
    without: bool,

    /// render without a window, write this PNG and quit
    #[argh(option)]
    headless: Option<String>,
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    let prewarms = !args.without;
    let game = move |app: &mut App| add_game(app, prewarms);
    if let Some(path) = args.headless {
        let headless = Headless::with(UVec2::new(1280, 720), game);
        return run::write_picture(headless, &path, 8);
    }
    App::new()
        .add_plugins((DefaultPlugins, LeanDeferredPlugins))
        .add_plugins(game)
        .run()
}

fn add_game(app: &mut App, prewarms: bool) {
    let spawn_camera = move |commands: Commands| spawn_camera(commands, prewarms);
    app.add_systems(Startup, (spawn_camera, spawn_level, spawn_loading_screen))
        .add_systems(
            Update,
            (
                load.run_if(not(resource_exists::<SceneReady>)),
                play.run_if(resource_exists::<SceneReady>),
            ),
        );
}

/// Covers the picture until the level is ready.
#[derive(Component)]
struct LoadingScreen;

/// Its progress bar.
#[derive(Component)]
struct Bar;

/// The text below, and later that of the level.
#[derive(Component)]
struct Report;

/// Appears after the others with lower numbers.
#[derive(Component)]
struct Appears(usize);

fn spawn_camera(mut commands: Commands, prewarms: bool) {
    let mut camera = commands.spawn((
        Camera3d::default(),
        LeanDeferred::default(),
        LeanScreenSpaceReflections::default(),
        IsDefaultUiCamera,
        Transform::from_xyz(0.0, 2.2, 7.0).looking_at(Vec3::new(0.0, 0.7, 0.0), Vec3::Y),
    ));
    if prewarms {
        camera.insert(LeanPrewarm {
            // All else is in the world.
            features: vec![PrewarmFeatures::FOG],
            ..default()
        });
    }
}

/// Shows the progress, and ends the loading screen.
fn load(
    camera: Single<(Entity, Option<&LeanPrewarm>), With<Camera3d>>,
    screen: Single<Entity, With<LoadingScreen>>,
    mut bar: Single<&mut Node, With<Bar>>,
    mut text: Single<&mut Text, With<Report>>,
    mut commands: Commands,
) {
    let (camera, prewarm) = *camera;
    if let Some(prewarm) = prewarm
        && !prewarm.progress.is_done
    {
        let progress = prewarm.progress;
        bar.width = percent(100.0 * progress.fraction());
        text.0 = format!("{} of {} shaders", progress.done, progress.total);
        return;
    }
    commands.entity(*screen).despawn();
    commands.entity(camera).remove::<LeanPrewarm>();
    commands.insert_resource(SceneReady);
}

/// Frames after the loading screen that do not count: its entities are despawned in them.
const FIRST_FRAMES: u32 = 10;

/// Shows one thing more per second, and the longest frame so far.
fn play(
    time: Res<Time<Real>>,
    camera: Single<Entity, With<Camera3d>>,
    mut hidden: Query<(&mut Visibility, &Appears)>,
    mut text: Single<&mut Text, With<Report>>,
    mut commands: Commands,
    (mut frames, mut seconds, mut longest): (Local<u32>, Local<f32>, Local<f32>),
) {
    *frames += 1;
    if *frames <= FIRST_FRAMES {
        return;
    }
    let frame = time.delta_secs();
    let before = *seconds as usize;
    *seconds += frame;
    *longest = (*longest).max(frame);
    let now = *seconds as usize;
    for (mut visibility, appears) in &mut hidden {
        if appears.0 < now {
            visibility.set_if_neq(Visibility::Inherited);
        }
    }
    if before < THINGS && now >= THINGS {
        commands.entity(*camera).insert(DistanceFog {
            color: Color::srgb(0.35, 0.4, 0.5),
            falloff: FogFalloff::from_visibility(30.0),
            ..default()
        });
    }
    let lines = format!("Longest frame: {:.1} ms", 1e3 * *longest);
    if text.0 != lines {
        text.0 = lines;
    }
}

/// Things that appear before the fog.
const THINGS: usize = 5;

fn spawn_loading_screen(mut commands: Commands) {
    let screen = Node {
        width: percent(100.0),
        height: percent(100.0),
        align_items: AlignItems::Center,
        justify_content: JustifyContent::Center,
        ..default()
    };
    let frame = Node {
        width: px(420),
        height: px(24),
        padding: px(4).all(),
        ..default()
    };
    let bar = Node {
        width: percent(0.0),
        height: percent(100.0),
        ..default()
    };
    commands
        .spawn((
            LoadingScreen,
            screen,
            BackgroundColor(Color::srgb(0.05, 0.05, 0.07)),
        ))
        .with_children(|screen| {
            screen
                .spawn((frame, BackgroundColor(Color::srgb(0.2, 0.2, 0.2))))
                .with_child((Bar, bar, BackgroundColor(Color::srgb(0.15, 0.4, 0.7))));
        });
    let place = Node {
        position_type: PositionType::Absolute,
        bottom: px(12),
        left: px(12),
        ..default()
    };
    // Above the loading screen.
    commands.spawn((
        Report,
        place,
        GlobalZIndex(1),
        Text::default(),
        TextFont::from_font_size(18.0),
    ));
}

/// A floor and a pillar under a sun. The rest is hidden: it is compiled all the same.
fn spawn_level(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        DirectionalLight {
            illuminance: 2_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(3.0, 8.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(16.0, 16.0))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.3, 0.3, 0.33),
            perceptual_roughness: 0.2,
            ..default()
        })),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cuboid::new(0.8, 2.4, 0.8))),
        MeshMaterial3d(materials.add(Color::srgb(0.7, 0.65, 0.6))),
        Transform::from_xyz(0.0, 1.2, -2.0),
    ));
    let ball = meshes.add(Sphere::new(0.7).mesh().uv(48, 24));
    let surfaces = [
        StandardMaterial {
            base_color: Color::BLACK,
            emissive: LinearRgba::rgb(40.0, 220.0, 120.0),
            ..default()
        },
        StandardMaterial {
            base_color: Color::srgb(0.6, 0.05, 0.05),
            clearcoat: 1.0,
            perceptual_roughness: 0.6,
            ..default()
        },
        StandardMaterial {
            base_color: Color::srgb(0.9, 0.9, 0.8),
            diffuse_transmission: 0.7,
            thickness: 0.2,
            ..default()
        },
    ];
    for (number, surface) in surfaces.into_iter().enumerate() {
        commands.spawn((
            Mesh3d(ball.clone()),
            MeshMaterial3d(materials.add(surface)),
            Transform::from_xyz(-2.4 + 2.4 * number as f32, 0.7, 0.6),
            Visibility::Hidden,
            Appears(number),
        ));
    }
    commands.spawn((
        SpotLight {
            intensity: 900_000.0,
            color: Color::srgb(1.0, 0.8, 0.5),
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(-3.0, 4.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
        Visibility::Hidden,
        Appears(3),
    ));
    commands.spawn((
        RectLight {
            intensity: 500_000.0,
            width: 2.0,
            height: 1.0,
            ..default()
        },
        Transform::from_xyz(3.0, 2.0, 2.0).looking_at(Vec3::new(1.0, 0.5, 0.0), Vec3::Y),
        Visibility::Hidden,
        Appears(4),
    ));
}
