//! Settings that the keys change, and the system that applies them to the camera.

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    pbr::ScreenSpaceReflections,
    prelude::*,
};
use bevy_lean_deferred::prelude::*;

use crate::room::Switched;
use kit::example::{choices::next, debug_view::DebugChoice, opaque_method::OpaqueMethod};

/// The effect on the camera, beside reflections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    None,
    Occlusion,
    Gi,
}

pub const EFFECTS: [Effect; 3] = [Effect::None, Effect::Occlusion, Effect::Gi];

/// The reflections on the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mirrors {
    Off,
    Low,
    Medium,
    High,
    Ultra,
    /// Bevy's `ScreenSpaceReflections` on its deferred path, without the other effects.
    Bevy,
}

pub const MIRRORS: [Mirrors; 6] = [
    Mirrors::Off,
    Mirrors::Low,
    Mirrors::Medium,
    Mirrors::High,
    Mirrors::Ultra,
    Mirrors::Bevy,
];

/// The debug views of the effects.
pub const DEBUG_VIEWS: [DebugView; 5] = [
    DebugView::GiLight,
    DebugView::GiVisibility,
    DebugView::ReflectionLight,
    DebugView::ReflectionConfidence,
    DebugView::ReflectionHit,
];

impl Mirrors {
    pub fn quality(self) -> Option<LeanQuality> {
        match self {
            Self::Off | Self::Bevy => None,
            Self::Low => Some(LeanQuality::Low),
            Self::Medium => Some(LeanQuality::Medium),
            Self::High => Some(LeanQuality::High),
            Self::Ultra => Some(LeanQuality::Ultra),
        }
    }
}

/// Factor between two radii.
const RADIUS_STEP: f32 = 1.25;

#[derive(Resource, Clone)]
pub struct ExampleSettings {
    pub effect: Effect,
    pub gi: LeanScreenSpaceGi,
    pub mirrors: Mirrors,
    pub debug: DebugChoice,
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
                settings.gi.quality = next(&LeanQuality::ALL, settings.gi.quality);
            }
            KeyCode::KeyM => settings.mirrors = next(&MIRRORS, settings.mirrors),
            KeyCode::KeyD => settings.debug.change_view(&DEBUG_VIEWS),
            KeyCode::KeyB => settings.debug.change_split(),
            KeyCode::KeyR => {
                settings.gi.resolution = next(&LeanResolution::ALL, settings.gi.resolution);
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
    mut method: OpaqueMethod,
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
        LeanScreenSpaceAmbientOcclusion,
        LeanScreenSpaceGi,
        LeanScreenSpaceReflections,
        ScreenSpaceReflections,
        DeferredPrepass,
        DepthPrepass,
    )>();
    settings.debug.put_on(&mut camera);
    let is_bevys = settings.mirrors == Mirrors::Bevy;
    method.set(is_bevys);
    if is_bevys {
        camera.remove::<LeanDeferred>();
        // Requires both prepasses. Reflects from roughness 0 on, as this crate's do.
        camera.insert(ScreenSpaceReflections {
            min_perceptual_roughness: 0.0..0.0,
            ..default()
        });
        return;
    }
    camera.insert_if_new(LeanDeferred::default());
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
            camera.insert(LeanScreenSpaceAmbientOcclusion::default());
        }
        Effect::Gi => {
            camera.insert(settings.gi);
        }
    }
}
