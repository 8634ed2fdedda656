//! Balls of every shading model and parameter that the G-buffer carries: lean beside forward.
//!
//! `cargo run --example materials -- [--headless OUT.png] [--help]`
//!
//! Each has a row; `rows.rs` lists them from top to bottom. Both halves show the same scene from the same place. Subsurface
//! scattering is in the left one only: forward has none.
//!
//! The keys 1, 2 and 3 choose both halves, lean alone and forward alone; `docs/examples.md` lists the others. Mouse, over the left
//! half: left orbits, right pans, the wheel zooms.
//!
//! `--headless` writes a PNG. With lean beside forward it also prints the differences between the halves.

mod cameras;
mod figures;
mod grid;
mod rows;

use bevy::{
    camera::{Hdr, ShadowLodOrigin},
    light::AmbientLight,
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
    window::WindowResized,
};
use bevy_lean_deferred::{gbuffer::GBufferUsage, prelude::*};
use bevy_panorbit_camera::PanOrbitCamera;
use cameras::{PictureSize, Shown, Side};
use kit::example::{
    choices,
    keys::{Technique, TechniquePlugin},
    panel::{Panel, PanelCamera, fixed_panel, panel},
    run::SceneReady,
    switch::Environment,
};
use rows::ROWS;

kit::example_args! {
    /// Balls of every shading model that the G-buffer carries: lean beside forward.
    struct Args {
        /// both (the default), lean or forward
        #[argh(option, default = "Shown::Both", from_str_fn(shown))]
        shown: Shown,
    }
}

fn shown(text: &str) -> Result<Shown, String> {
    choices::parse(&Shown::CHOICES, text)
}

fn main() -> AppExit {
    const FRAMES: usize = 8;
    let args: Args = argh::from_env();
    let frames = args.frames.unwrap_or(FRAMES);
    let example = args
        .example("materials", UVec2::new(1280, 860), FRAMES)
        .written_by(move |headless, path| figures::write_pictures(headless, path, frames));
    App::new()
        .insert_resource(PictureSize(example.size))
        .add_plugins((
            example.set_up(DefaultPlugins),
            LeanDeferredPlugins,
            example,
            TechniquePlugin(args.shown),
            panel::<LeanDeferred>("LeanDeferred"),
            panel::<LeanSubsurfaceScattering>("LeanSubsurfaceScattering"),
            fixed_panel::<Environment>("environment light"),
        ))
        .insert_resource(SceneReady)
        .add_systems(Startup, (grid::spawn, grid::spawn_lights, spawn_cameras))
        .add_systems(
            Update,
            (
                cameras::arrange
                    .run_if(resource_changed::<Shown>.or_else(on_message::<WindowResized>)),
                cameras::light,
                write_head,
            ),
        )
        .add_systems(PostUpdate, cameras::follow)
        .run()
}

/// Narrow, so that rows and columns look alike.
const FOV: f32 = 0.35;

fn spawn_cameras(mut commands: Commands, picture: Res<PictureSize>) {
    let half_size = grid::half_size();
    let aspect = picture.0.x as f32 / 2.0 / picture.0.y as f32;
    let distance = half_size.y.max(half_size.x / aspect) / (FOV / 2.0).tan();
    for (order, side) in [Side::Left, Side::Right].into_iter().enumerate() {
        let mut camera = commands.spawn((
            side,
            Camera3d::default(),
            Camera {
                order: order as isize,
                ..default()
            },
            Projection::Perspective(PerspectiveProjection {
                fov: FOV,
                ..default()
            }),
            // LeanDeferred needs it; both have it, so that they compare.
            Hdr,
            Msaa::Off,
            AmbientLight {
                brightness: 100.0,
                ..default()
            },
            DistanceFog {
                color: Color::srgb(0.45, 0.55, 0.75),
                // A tenth of the fog at the grid, half of it at the row about fog.
                falloff: FogFalloff::Linear {
                    start: distance - 1.0,
                    end: distance + 9.0,
                },
                ..default()
            },
            Transform::from_xyz(0.0, 0.0, distance),
        ));
        if side == Side::Left {
            camera.insert((
                LeanDeferred::default(),
                LeanSubsurfaceScattering::default(),
                PanelCamera,
                Environment::default(),
                PanOrbitCamera {
                    button_orbit: MouseButton::Left,
                    button_pan: MouseButton::Right,
                    ..default()
                },
                ShadowLodOrigin,
            ));
        }
    }
}

/// Writes the targets of the G-buffer, and the rows.
fn write_head(usage: Query<&GBufferUsage>, mut panel: ResMut<Panel>) {
    let rows = ROWS
        .iter()
        .map(|row| format!("{}: {}", row.name, row.steps));
    let active = usage.iter().find(|usage| usage.is_active());
    let targets = active.map(|usage| {
        let targets: Vec<_> = usage.each().map(|(name, _)| name).collect();
        let bytes = usage.bytes_per_pixel();
        format!(
            "G-buffer: {}: {bytes} bytes a pixel beside depth",
            targets.join(", ")
        )
    });
    panel.head = targets
        .into_iter()
        .chain(rows)
        .collect::<Vec<_>>()
        .join("\n");
}
