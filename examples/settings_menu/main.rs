//! A menu of graphics settings: a button for each preset, and what the camera has of it.
//!
//! `cargo run --example settings_menu -- [--preset high] [--headless OUT.png] [--help]`

use argh::FromArgs;
use bevy::{prelude::*, ui::IsDefaultUiCamera};
use bevy_lean_deferred::{material_extension::SubsurfaceAlbedo, prelude::*};

/// A menu of graphics settings.
#[derive(FromArgs)]
struct Args {
    /// low, medium (the default), high or ultra
    #[argh(option, default = "LeanPreset::default()")]
    preset: LeanPreset,

    /// render without a window, write this PNG and quit
    #[argh(option)]
    headless: Option<String>,
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    let game = move |app: &mut App| add_game(app, args.preset);
    // Writes the picture of the docs. Games need neither this nor `kit`, which is not published.
    if let Some(path) = args.headless {
        let headless = kit::headless::Headless::with(UVec2::new(1280, 720), |app| {
            app.insert_resource(kit::example::run::SceneReady);
            game(app);
        });
        return kit::example::run::write_picture(headless, &path, 8);
    }
    App::new()
        .add_plugins((DefaultPlugins, LeanDeferredPlugins))
        .add_plugins(game)
        .run()
}

fn add_game(app: &mut App, preset: LeanPreset) {
    app.insert_resource(Chosen(preset))
        .add_systems(Startup, (spawn_camera, spawn_room, spawn_menu))
        .add_systems(
            Update,
            (
                press_buttons,
                apply_preset.run_if(resource_changed::<Chosen>),
                color_buttons,
                report,
            )
                .chain(),
        );
}

/// The preset that the player has chosen. A game would store it: `LeanPreset` has `Display`, `FromStr` and, with the feature
/// `serialize`, serde's traits.
#[derive(Resource)]
struct Chosen(LeanPreset);

/// A button of the menu.
#[derive(Component)]
struct PresetButton(LeanPreset);

/// The text below the buttons.
#[derive(Component)]
struct Report;

fn spawn_camera(mut commands: Commands) {
    commands.spawn((
        Camera3d::default(),
        LeanDeferred::default(),
        // A setting of the game itself. Presets keep it, also while they have no GI.
        LeanScreenSpaceGi {
            radius: 3.0,
            ..default()
        },
        // No part of presets.
        LeanAutoExposure::default(),
        // For the report.
        LeanMemory::default(),
        LeanForwardMeshes::default(),
        IsDefaultUiCamera,
        Transform::from_xyz(0.0, 1.6, 6.5).looking_at(Vec3::new(0.0, 1.1, 0.0), Vec3::Y),
    ));
}

/// Applies the chosen preset, at the start and when another one is chosen.
fn apply_preset(
    chosen: Res<Chosen>,
    camera: Single<Entity, With<Camera3d>>,
    mut commands: Commands,
) {
    chosen.0.apply(&mut commands.entity(*camera));
}

fn press_buttons(
    buttons: Query<(&Interaction, &PresetButton), Changed<Interaction>>,
    mut chosen: ResMut<Chosen>,
) {
    for (interaction, button) in &buttons {
        if *interaction == Interaction::Pressed {
            chosen.0 = button.0;
        }
    }
}

fn color_buttons(
    chosen: Res<Chosen>,
    mut buttons: Query<(&Interaction, &PresetButton, &mut BackgroundColor)>,
) {
    for (interaction, button, mut background) in &mut buttons {
        let color = match *interaction {
            _ if button.0 == chosen.0 => Color::srgb(0.15, 0.4, 0.7),
            Interaction::None => Color::srgb(0.2, 0.2, 0.2),
            Interaction::Hovered | Interaction::Pressed => Color::srgb(0.35, 0.35, 0.35),
        };
        background.set_if_neq(BackgroundColor(color));
    }
}

/// Writes which effects are on or why not, the GPU memory that they hold, and the meshes that Bevy's forward pass draws.
fn report(
    camera: Single<(&LeanStatus, &LeanMemory, &LeanForwardMeshes)>,
    mut text: Single<&mut Text, With<Report>>,
) {
    let (status, memory, forward_meshes) = *camera;
    let statuses = status
        .each()
        .map(|(component, status)| format!("{component}: {status}"));
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let parts = [
        ("G-buffer", memory.gbuffer),
        ("lighting", memory.lighting),
        ("history", memory.history),
        ("ambient occlusion", memory.ambient_occlusion),
        ("diffuse GI", memory.diffuse_gi),
        ("reflections", memory.reflections),
        ("scattering", memory.subsurface),
        ("auto exposure", memory.auto_exposure),
    ];
    let parts = parts.into_iter().filter(|(_, bytes)| *bytes > 0);
    let parts = parts.map(|(name, bytes)| format!("  {name} {:.2} MiB", mib(bytes)));
    let total = format!("GPU memory {:.2} MiB", mib(memory.total()));
    let meshes = forward_meshes.counts.iter();
    let meshes = meshes.map(|(reason, count)| format!("{count} drawn forward: {reason}"));
    let lines: Vec<String> = statuses.chain([total]).chain(parts).chain(meshes).collect();
    let lines = lines.join("\n");
    if text.0 != lines {
        text.0 = lines;
    }
}

fn spawn_menu(mut commands: Commands) {
    let menu = Node {
        position_type: PositionType::Absolute,
        top: px(12),
        left: px(12),
        max_width: px(420),
        padding: px(12).all(),
        row_gap: px(8),
        flex_direction: FlexDirection::Column,
        ..default()
    };
    let row = Node {
        column_gap: px(8),
        ..default()
    };
    let button = Node {
        padding: px(8).all(),
        ..default()
    };
    commands
        .spawn((menu, BackgroundColor(Color::BLACK.with_alpha(0.75))))
        .with_children(|menu| {
            menu.spawn(row).with_children(|row| {
                for preset in LeanPreset::ALL {
                    row.spawn((
                        Button,
                        PresetButton(preset),
                        button.clone(),
                        BackgroundColor::default(),
                        children![(
                            Text::new(preset.to_string()),
                            TextFont::from_font_size(18.0)
                        )],
                    ));
                }
            });
            menu.spawn((Report, Text::default(), TextFont::from_font_size(14.0)));
        });
}

/// Walls that illuminate each other, a polished floor, a ball that scatters light, and one that forward draws.
fn spawn_room(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut extended_materials: ResMut<Assets<ExtendedStandardMaterial>>,
) {
    let mut matte = |color: Color, perceptual_roughness| {
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness,
            ..default()
        }))
    };
    let mut cuboid = |size: Vec3| Mesh3d(meshes.add(Cuboid::from_size(size)));
    commands.spawn((
        cuboid(Vec3::new(6.0, 0.1, 6.0)),
        matte(Color::srgb(0.25, 0.25, 0.28), 0.15),
        Transform::from_xyz(0.0, -0.05, 0.0),
    ));
    commands.spawn((
        cuboid(Vec3::new(6.0, 3.0, 0.1)),
        matte(Color::srgb(0.8, 0.8, 0.8), 0.9),
        Transform::from_xyz(0.0, 1.5, -3.0),
    ));
    for (x, color) in [
        (-3.0, Color::srgb(0.8, 0.15, 0.1)),
        (3.0, Color::srgb(0.15, 0.6, 0.2)),
    ] {
        commands.spawn((
            cuboid(Vec3::new(0.1, 3.0, 6.0)),
            matte(color, 0.9),
            Transform::from_xyz(x, 1.5, 0.0),
        ));
    }
    commands.spawn((
        cuboid(Vec3::new(1.0, 1.8, 1.0)),
        matte(Color::srgb(0.85, 0.8, 0.7), 0.8),
        Transform::from_xyz(-1.4, 0.9, -1.2).with_rotation(Quat::from_rotation_y(0.4)),
    ));
    commands.spawn((
        PointLight {
            intensity: 400_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(0.3, 2.6, 0.6),
    ));
    let skin = ExtendedStandardMaterial {
        base: Color::srgb(0.85, 0.7, 0.6).into(),
        extension: ShadingExtension::Subsurface {
            color: LinearRgba::rgb(1.0, 0.35, 0.2).into(),
            mean_free_path: 0.02,
            albedo: SubsurfaceAlbedo::AfterScattering,
        },
    };
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(0.6).mesh().uv(48, 24))),
        MeshMaterial3d(extended_materials.add(skin)),
        Transform::from_xyz(0.5, 0.6, 0.2),
    ));
    let glass = StandardMaterial {
        base_color: Color::srgba(0.5, 0.75, 1.0, 0.3),
        alpha_mode: AlphaMode::Blend,
        ..default()
    };
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(0.4).mesh().uv(48, 24))),
        MeshMaterial3d(materials.add(glass)),
        Transform::from_xyz(1.8, 0.4, 0.9),
    ));
}
