//! Settings that the keys change, and the systems that apply them to the camera.

use bevy::{camera::Exposure, prelude::*};
use kit::{
    example::{choices::next, opaque_method::OpaqueMethod},
    renderer::Renderer,
};
use street::{Viewpoint, Walking};

use crate::effects::Effect;

/// Settings that the keys change.
#[derive(Resource, Clone)]
pub struct Settings {
    pub renderer: Renderer,
    /// The active effects, on lean cameras.
    pub effects: Vec<Effect>,
    pub viewpoint: Viewpoint,
    /// `None` for the scene's exposure.
    pub exposure: Option<Exposure>,
    pub walk: bool,
    pub text: bool,
}

const VIEWPOINTS: [Viewpoint; 4] = [
    Viewpoint::STREET,
    Viewpoint::STALL,
    Viewpoint::PUDDLE,
    Viewpoint::CATS,
];

/// Inserts the first settings, and adds the systems that change and apply them.
pub struct SettingsPlugin {
    first: Settings,
    has_keys: bool,
}

impl SettingsPlugin {
    /// All effects are on, and keys change the settings.
    pub fn of_window() -> Self {
        Self {
            first: Settings {
                renderer: Renderer::Lean,
                effects: vec![
                    Effect::DiffuseGi,
                    Effect::Reflections,
                    Effect::SubsurfaceScattering,
                    Effect::AutoExposure,
                ],
                viewpoint: Viewpoint::STREET,
                exposure: None,
                walk: true,
                text: true,
            },
            has_keys: true,
        }
    }

    /// Nothing moves, and forward comes first.
    pub fn of_pictures() -> Self {
        Self {
            first: Settings {
                renderer: Renderer::Forward,
                effects: Vec::new(),
                walk: false,
                text: false,
                ..Self::of_window().first
            },
            has_keys: false,
        }
    }
}

impl Plugin for SettingsPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(self.first.clone())
            .add_systems(Update, apply.run_if(resource_changed::<Settings>));
        if self.has_keys {
            app.add_systems(Update, read_keys.before(apply));
        }
    }
}

fn read_keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut settings: ResMut<Settings>,
    mut exit: MessageWriter<AppExit>,
) {
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::Digit1 => settings.renderer = Renderer::Forward,
            KeyCode::Digit2 => settings.renderer = Renderer::BevyDeferred,
            KeyCode::Digit3 => settings.renderer = Renderer::Lean,
            KeyCode::KeyV => settings.viewpoint = next(&VIEWPOINTS, settings.viewpoint),
            KeyCode::KeyP => settings.walk = !settings.walk,
            KeyCode::KeyH => settings.text = !settings.text,
            KeyCode::Escape => {
                exit.write(AppExit::Success);
            }
            key => {
                let effect = Effect::ALL.into_iter().find(|effect| effect.key() == *key);
                if let Some(effect) = effect {
                    settings.toggle(effect);
                }
            }
        }
    }
}

impl Settings {
    pub fn toggle(&mut self, effect: Effect) {
        match self.effects.contains(&effect) {
            true => self.effects.retain(|other| *other != effect),
            false => self.effects.push(effect),
        }
    }
}

fn apply(
    mut commands: Commands,
    settings: Res<Settings>,
    camera: Single<(Entity, Option<&Exposure>), With<Camera3d>>,
    mut method: OpaqueMethod,
    mut first_exposure: Local<Option<Exposure>>,
) {
    let (camera, exposure) = *camera;
    let own = *first_exposure.get_or_insert(exposure.copied().unwrap_or_default());
    let mut camera = commands.entity(camera);
    settings.renderer.prepare_camera(&mut camera);
    camera.insert(settings.exposure.unwrap_or(own));
    for effect in Effect::ALL {
        let is_on = settings.renderer == Renderer::Lean && settings.effects.contains(&effect);
        effect.switch(&mut camera, is_on);
    }
    method.set(settings.renderer == Renderer::BevyDeferred);
    commands.insert_resource(Walking(if settings.walk { 1.0 } else { 0.0 }));
}
