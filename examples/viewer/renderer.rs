//! Switching between the renderers.

use bevy::{core_pipeline::tonemapping::Tonemapping, prelude::*};
use bevy_lean_deferred::prelude::*;

use kit::{
    example::{
        debug_view::{DebugChoice, views_of_lighting},
        opaque_method::OpaqueMethod,
    },
    renderer::Renderer,
};

/// Settings that the keys change.
#[derive(Resource, Clone)]
pub struct ViewerSettings {
    pub renderer: Renderer,
    pub debug: DebugChoice,
    pub sun: bool,
    pub environment: bool,
    pub text: bool,
}

impl Default for ViewerSettings {
    fn default() -> Self {
        Self {
            renderer: Renderer::Lean,
            debug: default(),
            sun: true,
            environment: true,
            text: true,
        }
    }
}

pub fn read_keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut settings: ResMut<ViewerSettings>,
    mut exit: MessageWriter<AppExit>,
) {
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::Digit1 => settings.renderer = Renderer::Forward,
            KeyCode::Digit2 => settings.renderer = Renderer::BevyDeferred,
            KeyCode::Digit3 => settings.renderer = Renderer::Lean,
            KeyCode::KeyD => settings.debug.change_view(&views_of_lighting()),
            KeyCode::KeyB => settings.debug.change_split(),
            KeyCode::KeyL => settings.sun = !settings.sun,
            KeyCode::KeyE => settings.environment = !settings.environment,
            KeyCode::KeyH => settings.text = !settings.text,
            KeyCode::Escape => {
                exit.write(AppExit::Success);
            }
            _ => {}
        }
    }
}

pub fn apply_settings(
    mut commands: Commands,
    settings: Res<ViewerSettings>,
    camera: Single<Entity, With<Camera3d>>,
    mut method: OpaqueMethod,
) {
    let mut camera = commands.entity(*camera);
    settings.renderer.prepare_camera(&mut camera);
    method.set(settings.renderer == Renderer::BevyDeferred);
    if settings.renderer == Renderer::Lean {
        camera.insert(LeanDeferred::default());
    }
    settings.debug.put_on(&mut camera);
    let shows_data = settings.renderer == Renderer::Lean && settings.debug.is_whole();
    camera.insert(if shows_data {
        Tonemapping::None
    } else {
        Tonemapping::TonyMcMapface
    });
}
