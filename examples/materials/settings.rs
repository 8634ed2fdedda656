//! The cameras, and the settings of them that the keys change.

use bevy::{
    camera::{Hdr, ShadowLodOrigin, Viewport},
    core_pipeline::tonemapping::Tonemapping,
    light::{AmbientLight, EnvironmentMapLight, GeneratedEnvironmentMapLight},
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
    ui::IsDefaultUiCamera,
};
use bevy_lean_deferred::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;

use crate::grid::{self, Sun};
use kit::example::{
    debug_view::{DebugChoice, views_of_lighting},
    made_up_sky::made_up_sky,
};

/// The active cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    Both,
    Lean,
    Forward,
}

pub const SHOWN: [Shown; 3] = [Shown::Both, Shown::Lean, Shown::Forward];

#[derive(Resource, Clone)]
pub struct ExampleSettings {
    pub shown: Shown,
    pub debug: DebugChoice,
    pub sun: bool,
    pub environment: bool,
    /// Light scatters beneath surfaces.
    pub scattering: bool,
    pub text: bool,
    /// Size of the picture without a window.
    pub picture: UVec2,
}

/// The half of the picture that a camera draws.
#[derive(Component, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The camera with `LeanDeferred`.
    Left,
    /// The camera of Bevy's forward renderer.
    Right,
}

/// Narrow, so that rows and columns look alike.
const FOV: f32 = 0.35;

pub fn spawn_cameras(mut commands: Commands, settings: Res<ExampleSettings>) {
    let half_size = grid::half_size();
    let aspect = settings.picture.x as f32 / 2.0 / settings.picture.y as f32;
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

/// Moves the right camera to the place of the left one.
pub fn follow(mut cameras: Query<(&Side, &mut Transform)>) {
    let left = cameras.iter().find(|(side, _)| **side == Side::Left);
    let Some(place) = left.map(|(_, transform)| *transform) else {
        return;
    };
    for (_, mut transform) in &mut cameras {
        transform.set_if_neq(place);
    }
}

pub fn read_keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut settings: ResMut<ExampleSettings>,
    mut exit: MessageWriter<AppExit>,
) {
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::Digit1 => settings.shown = Shown::Both,
            KeyCode::Digit2 => settings.shown = Shown::Lean,
            KeyCode::Digit3 => settings.shown = Shown::Forward,
            KeyCode::KeyD => settings.debug.change_view(&views_of_lighting()),
            KeyCode::KeyB => settings.debug.change_split(),
            KeyCode::KeyL => settings.sun = !settings.sun,
            KeyCode::KeyE => settings.environment = !settings.environment,
            KeyCode::KeyS => settings.scattering = !settings.scattering,
            KeyCode::KeyH => settings.text = !settings.text,
            KeyCode::Escape => {
                exit.write(AppExit::Success);
            }
            _ => {}
        }
    }
}

pub fn apply(
    mut commands: Commands,
    settings: Res<ExampleSettings>,
    mut cameras: Query<(Entity, &Side, &mut Camera)>,
    windows: Query<&Window>,
    mut sun: Single<&mut Visibility, With<Sun>>,
    mut images: ResMut<Assets<Image>>,
    mut sky: Local<Option<Handle<Image>>>,
) {
    sun.set_if_neq(if settings.sun {
        Visibility::Inherited
    } else {
        Visibility::Hidden
    });
    let sky = sky.get_or_insert_with(|| images.add(made_up_sky()));
    let window = windows.iter().next().map(Window::physical_size);
    let picture = window.unwrap_or(settings.picture);
    for (entity, side, mut camera) in &mut cameras {
        camera.is_active = match side {
            Side::Left => settings.shown != Shown::Forward,
            Side::Right => settings.shown != Shown::Lean,
        };
        camera.viewport = (settings.shown == Shown::Both).then(|| half(picture, *side));

        let mut entity = commands.entity(entity);
        // The leftmost camera shows the panel.
        let has_panel = (*side == Side::Left) == (settings.shown != Shown::Forward);
        if has_panel {
            entity.insert(IsDefaultUiCamera);
        } else {
            entity.remove::<IsDefaultUiCamera>();
        }
        if *side == Side::Left {
            entity.insert(LeanDeferred::default());
            settings.debug.put_on(&mut entity);
            if settings.scattering {
                entity.insert(LeanSubsurfaceScattering::default());
            } else {
                entity.remove::<LeanSubsurfaceScattering>();
            }
        }
        let shows_data = *side == Side::Left && settings.debug.is_whole();
        entity.insert(if shows_data {
            Tonemapping::None
        } else {
            Tonemapping::TonyMcMapface
        });
        if settings.environment {
            entity.insert_if_new(GeneratedEnvironmentMapLight {
                environment_map: sky.clone(),
                intensity: 900.0,
                ..default()
            });
        } else {
            entity.remove::<(GeneratedEnvironmentMapLight, EnvironmentMapLight)>();
        }
    }
}

fn half(picture: UVec2, side: Side) -> Viewport {
    let width = (picture.x / 2).max(1);
    Viewport {
        physical_position: match side {
            Side::Left => UVec2::ZERO,
            Side::Right => UVec2::new(picture.x - width, 0),
        },
        physical_size: UVec2::new(width, picture.y.max(1)),
        ..default()
    }
}
