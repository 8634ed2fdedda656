//! Components that an example switches off and on again with the same settings.

use bevy::prelude::*;

/// A component that is off.
#[derive(Component)]
struct SwitchedOff<C: Component>(C);

/// Inserts `C`, as it was before or with its defaults, or removes it.
pub fn switch<C: Component + Default>(camera: &mut EntityCommands, is_on: bool) {
    camera.queue(move |mut camera: EntityWorldMut| switch_now::<C>(&mut camera, is_on));
}

/// As [`switch`], at once.
pub fn switch_now<C: Component + Default>(camera: &mut EntityWorldMut, is_on: bool) {
    if is_on && !camera.contains::<C>() {
        let before = camera.take::<SwitchedOff<C>>();
        camera.insert(before.map_or_else(C::default, |before| before.0));
    } else if !is_on && let Some(component) = camera.take::<C>() {
        camera.insert(SwitchedOff(component));
    }
}

/// Marks lights that the key L and `--dark` switch.
#[derive(Component)]
pub struct SwitchedLight;

/// Switches these lights off, or on if they are off.
pub fn switch_lights(mut lights: Query<&mut Visibility, With<SwitchedLight>>) {
    for mut light in &mut lights {
        *light = match *light {
            Visibility::Hidden => Visibility::Inherited,
            _ => Visibility::Hidden,
        };
    }
}

/// On a camera, for the panel: the example lights it by an environment.
#[derive(Component, Reflect)]
#[reflect(Component, Default)]
pub struct Environment {
    pub is_on: bool,
}

impl Default for Environment {
    fn default() -> Self {
        Self { is_on: true }
    }
}
