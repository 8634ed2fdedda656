//! Diffuse GI and reflections: a room with a polished floor, lit by the sun through a window (or any glTF or GLB file).
//!
//! `cargo run --example screen_space -- [FILE] [--headless OUT.png] [--help]`
//!
//! The keys 1, 2 and 3 choose ambient occlusion alone, `LeanScreenSpaceGi` with `LeanScreenSpaceReflections`, and Bevy's
//! `ScreenSpaceReflections` on its deferred path; the panel and `--set` switch each effect. `docs/examples.md` lists the other keys.
//! Mouse: left orbits, right pans, the wheel zooms.

mod room;

use bevy::{
    camera::{Exposure, Hdr},
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    pbr::ScreenSpaceReflections,
    prelude::*,
    ui::IsDefaultUiCamera,
};
use bevy_lean_deferred::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;
use kit::example::{
    choices,
    keys::{Technique, TechniquePlugin},
    made_up_sky::made_up_sky,
    model::{self, ModelPath, Viewpoint},
    numbers::{finite, positive},
    opaque_method::OpaqueMethod,
    panel::{PanelCamera, panel},
    switch::{SwitchedLight, switch},
};

kit::example_args! {
    /// Diffuse GI and reflections in a room lit through a window, or in a glTF or GLB file.
    struct Args {
        /// the file to show; a room when left out
        #[argh(positional)]
        file: Option<String>,

        /// occlusion, gi (the default) or bevy
        #[argh(option, default = "Effects::Gi", from_str_fn(effects))]
        effects: Effects,

        /// direction of the camera in degrees, default 0
        #[argh(option, default = "0.0", from_str_fn(finite))]
        yaw: f32,

        /// height of the camera in degrees, default 5
        #[argh(option, default = "5.0", from_str_fn(finite))]
        pitch: f32,

        /// zoom factor of the camera, default 1
        #[argh(option, default = "1.0", from_str_fn(positive))]
        zoom: f32,
    }
}

/// The effects on the camera.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
enum Effects {
    Occlusion,
    Gi,
    /// Bevy's `ScreenSpaceReflections` on its deferred path, without the effects of this crate.
    Bevy,
}

impl Technique for Effects {
    const CHOICES: [Self; 3] = [Self::Occlusion, Self::Gi, Self::Bevy];

    fn title(self) -> &'static str {
        match self {
            Self::Occlusion => "occlusion",
            Self::Gi => "GI and reflections",
            Self::Bevy => "Bevy's reflections",
        }
    }
}

fn effects(text: &str) -> Result<Effects, String> {
    choices::parse(&Effects::CHOICES, text)
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    if let Err(message) = args.file.as_deref().map_or(Ok(()), model::check_file) {
        eprintln!("error: {message}");
        return AppExit::error();
    }
    // Light bounces once per frame.
    let example = args.example("screen space", UVec2::new(1280, 720), 16);
    App::new()
        .add_plugins((
            example.set_up(DefaultPlugins),
            LeanDeferredPlugins,
            example,
            TechniquePlugin(args.effects),
            panel::<LeanScreenSpaceGi>("LeanScreenSpaceGi"),
            panel::<LeanScreenSpaceReflections>("LeanScreenSpaceReflections"),
            panel::<LeanScreenSpaceAmbientOcclusion>("LeanScreenSpaceAmbientOcclusion"),
            panel::<ScreenSpaceReflections>("Bevy's ScreenSpaceReflections"),
        ))
        .insert_resource(ModelPath(args.file))
        .insert_resource(Viewpoint::from_degrees(args.yaw, args.pitch, args.zoom))
        .add_systems(
            Startup,
            (
                spawn_camera,
                // Before `--set`, which may switch an effect.
                apply,
                model::spawn_model,
                spawn_sun.run_if(not(model::is_builtin)),
                (room::spawn, room::spawn_lights, room::stand_camera).run_if(model::is_builtin),
            )
                .chain(),
        )
        .add_systems(
            Update,
            (
                model::watch_loading,
                apply.run_if(resource_changed::<Effects>.and_then(not(resource_added::<Effects>))),
            ),
        )
        .run()
}

/// The sun on a file.
fn spawn_sun(mut commands: Commands) {
    commands.spawn((
        SwitchedLight,
        DirectionalLight {
            illuminance: 20_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(1.0, 2.0, 2.6).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

fn spawn_camera(mut commands: Commands, mut images: ResMut<Assets<Image>>) {
    let sky = images.add(made_up_sky());
    commands.spawn((
        Camera3d::default(),
        LeanDeferred::default(),
        LeanScreenSpaceGi::default(),
        LeanScreenSpaceReflections::default(),
        Hdr,
        Msaa::Off,
        Exposure::OVERCAST,
        GeneratedEnvironmentMapLight {
            environment_map: sky,
            intensity: 1_500.0,
            ..default()
        },
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

fn apply(
    mut commands: Commands,
    effects: Res<Effects>,
    camera: Single<Entity, With<PanelCamera>>,
    mut method: OpaqueMethod,
) {
    let mut camera = commands.entity(*camera);
    let is_bevys = *effects == Effects::Bevy;
    // Before the effects, which would add it with its defaults.
    switch::<LeanDeferred>(&mut camera, !is_bevys);
    switch::<LeanScreenSpaceAmbientOcclusion>(&mut camera, *effects == Effects::Occlusion);
    switch::<LeanScreenSpaceGi>(&mut camera, *effects == Effects::Gi);
    switch::<LeanScreenSpaceReflections>(&mut camera, *effects == Effects::Gi);
    if is_bevys {
        // Requires both prepasses. Reflects from roughness 0 on, as this crate's do.
        camera.insert_if_new(ScreenSpaceReflections {
            min_perceptual_roughness: 0.0..0.0,
            ..default()
        });
    } else {
        camera.remove::<(ScreenSpaceReflections, DeferredPrepass, DepthPrepass)>();
    }
    method.set(is_bevys);
}
