//! Cameras: their parts of the window, and the views of the scene.

use bevy::{
    camera::Viewport,
    light::{EnvironmentMapLight, GeneratedEnvironmentMapLight},
    prelude::*,
    ui::IsDefaultUiCamera,
};

use kit::example::{keys::Technique, made_up_sky::made_up_sky, switch::Environment};

/// The active cameras.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    Both,
    Lean,
    Forward,
}

impl Technique for Shown {
    const CHOICES: [Self; 3] = [Self::Both, Self::Lean, Self::Forward];

    fn title(self) -> &'static str {
        match self {
            Self::Both => "lean beside forward",
            Self::Lean => "lean",
            Self::Forward => "forward",
        }
    }
}

/// The half of the picture that a camera draws.
#[derive(Component, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The camera with `LeanDeferred`.
    Left,
    /// The camera of Bevy's forward renderer.
    Right,
}

/// Size of the picture without a window.
#[derive(Resource)]
pub struct PictureSize(pub UVec2);

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

/// Activates the cameras, and gives each its part of the picture.
pub fn arrange(
    mut commands: Commands,
    shown: Res<Shown>,
    size: Res<PictureSize>,
    mut cameras: Query<(Entity, &Side, &mut Camera)>,
    windows: Query<&Window>,
) {
    let window = windows.iter().next().map(Window::physical_size);
    let picture = window.unwrap_or(size.0);
    for (entity, side, mut camera) in &mut cameras {
        camera.is_active = match side {
            Side::Left => *shown != Shown::Forward,
            Side::Right => *shown != Shown::Lean,
        };
        camera.viewport = (*shown == Shown::Both).then(|| half(picture, *side));
        // The leftmost camera shows the panel.
        if (*side == Side::Left) == (*shown != Shown::Forward) {
            commands.entity(entity).insert(IsDefaultUiCamera);
        } else {
            commands.entity(entity).remove::<IsDefaultUiCamera>();
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

/// Lights both cameras by the sky, or without.
pub fn light(
    mut commands: Commands,
    environment: Single<&Environment, Changed<Environment>>,
    cameras: Query<Entity, With<Side>>,
    mut images: ResMut<Assets<Image>>,
    mut sky: Local<Option<Handle<Image>>>,
) {
    let sky = sky.get_or_insert_with(|| images.add(made_up_sky()));
    for camera in &cameras {
        let mut camera = commands.entity(camera);
        if environment.is_on {
            camera.insert(GeneratedEnvironmentMapLight {
                environment_map: sky.clone(),
                intensity: 900.0,
                ..default()
            });
        } else {
            camera.remove::<(GeneratedEnvironmentMapLight, EnvironmentMapLight)>();
        }
    }
}
