//! What the keys change, and its way onto the camera.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;

use crate::room::Switched;
use kit::example::choices::next;

/// What the camera has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    None,
    Occlusion,
    Gi,
}

pub const EFFECTS: [Effect; 3] = [Effect::None, Effect::Occlusion, Effect::Gi];

/// Whether the camera has reflections too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mirrors {
    Off,
    Low,
    Medium,
    High,
}

pub const MIRRORS: [Mirrors; 4] = [Mirrors::Off, Mirrors::Low, Mirrors::Medium, Mirrors::High];

impl Mirrors {
    pub fn quality(self) -> Option<ScreenSpaceReflectionsQuality> {
        match self {
            Self::Off => None,
            Self::Low => Some(ScreenSpaceReflectionsQuality::Low),
            Self::Medium => Some(ScreenSpaceReflectionsQuality::Medium),
            Self::High => Some(ScreenSpaceReflectionsQuality::High),
        }
    }
}

/// From one radius to the next larger one.
const RADIUS_STEP: f32 = 1.25;

#[derive(Resource, Clone)]
pub struct ExampleSettings {
    pub effect: Effect,
    pub gi: LeanScreenSpaceGi,
    pub mirrors: Mirrors,
    pub lights: bool,
    pub text: bool,
}

pub fn read_keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut settings: ResMut<ExampleSettings>,
    mut exit: MessageWriter<AppExit>,
) {
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::Digit1 => settings.effect = Effect::None,
            KeyCode::Digit2 => settings.effect = Effect::Occlusion,
            KeyCode::Digit3 => settings.effect = Effect::Gi,
            KeyCode::KeyQ => {
                settings.gi.quality = next(&ScreenSpaceGiQuality::ALL, settings.gi.quality);
            }
            KeyCode::KeyM => settings.mirrors = next(&MIRRORS, settings.mirrors),
            KeyCode::KeyR => {
                settings.gi.resolution = next(&ScreenSpaceResolution::ALL, settings.gi.resolution);
            }
            KeyCode::ArrowUp => settings.gi.radius *= RADIUS_STEP,
            KeyCode::ArrowDown => settings.gi.radius /= RADIUS_STEP,
            KeyCode::KeyL => settings.lights = !settings.lights,
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
    camera: Single<Entity, With<Camera3d>>,
    mut lights: Query<&mut Visibility, With<Switched>>,
) {
    for mut light in &mut lights {
        *light = if settings.lights {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        };
    }
    let mut camera = commands.entity(*camera);
    camera.remove::<(
        LeanAmbientOcclusion,
        LeanScreenSpaceGi,
        LeanScreenSpaceReflections,
    )>();
    if let Some(quality) = settings.mirrors.quality() {
        camera.insert(LeanScreenSpaceReflections {
            quality,
            resolution: settings.gi.resolution,
            ..default()
        });
    }
    match settings.effect {
        Effect::None => {}
        Effect::Occlusion => {
            camera.insert(LeanAmbientOcclusion::default());
        }
        Effect::Gi => {
            camera.insert(settings.gi);
        }
    }
}
