//! The keys of all examples.
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3 | renderer or technique |
//! | Q, R | next quality, next resolution; with Shift the one before |
//! | D, Shift+D | next debug view, the one before |
//! | B | debug view on the whole picture / on its left half |
//! | G | `LeanDeferred` on / off |
//! | L | lights on / off |
//! | H | text on / off |
//! | Tab, Up, Down | choose a setting of the panel |
//! | Left, Right | change it |
//! | Esc | quit |

use core::fmt::Debug;

use bevy::{
    diagnostic::DiagnosticsStore,
    ecs::{component::Mutable, system::RunSystemOnce},
    prelude::*,
};
use bevy_lean_deferred::LeanDeferred;

use super::{
    debug_view, gpu_times,
    panel::{self, Panel, cameras},
    switch::{switch_lights, switch_now},
};

pub fn read_keys(world: &mut World) {
    let keys = world.resource::<ButtonInput<KeyCode>>();
    let forward = !keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    let pressed: Vec<KeyCode> = keys.get_just_pressed().copied().collect();
    for key in pressed {
        match key {
            KeyCode::KeyQ => panel::change_all(world, "quality", forward),
            KeyCode::KeyR => panel::change_all(world, "resolution", forward),
            KeyCode::KeyD => debug_view::change_view(world, forward),
            KeyCode::KeyB => debug_view::change_split(world),
            KeyCode::KeyG => {
                for camera in cameras(world) {
                    let mut camera = world.entity_mut(camera);
                    let is_on = camera.contains::<LeanDeferred>();
                    switch_now::<LeanDeferred>(&mut camera, !is_on);
                }
            }
            KeyCode::KeyL => {
                if let Err(error) = world.run_system_once(switch_lights) {
                    error!("{error}");
                }
            }
            KeyCode::KeyH => {
                let mut panel = world.resource_mut::<Panel>();
                panel.is_hidden = !panel.is_hidden;
            }
            KeyCode::Tab => panel::choose_section(world, forward),
            KeyCode::ArrowDown => panel::choose_row(world, true),
            KeyCode::ArrowUp => panel::choose_row(world, false),
            KeyCode::ArrowRight => panel::change(world, true),
            KeyCode::ArrowLeft => panel::change(world, false),
            KeyCode::Escape => {
                world.write_message(AppExit::Success);
            }
            _ => continue,
        }
        // Passes that no longer run keep their last times.
        if let Some(mut diagnostics) = world.get_resource_mut::<DiagnosticsStore>() {
            gpu_times::forget(&mut diagnostics);
        }
    }
}

/// Variants of an example, which the keys 1, 2 and 3 select.
pub trait Technique: Resource<Mutability = Mutable> + Copy + Debug + PartialEq {
    /// In the order of the keys.
    const CHOICES: [Self; 3];

    /// The name on the panel.
    fn title(self) -> &'static str;
}

/// Inserts the first technique as a resource, which the keys 1, 2 and 3 change.
pub struct TechniquePlugin<T>(pub T);

impl<T: Technique> Plugin for TechniquePlugin<T> {
    fn build(&self, app: &mut App) {
        app.init_resource::<Panel>()
            .insert_resource(self.0)
            .add_systems(
                Update,
                (choose::<T>, write_titles::<T>.run_if(resource_changed::<T>)).chain(),
            );
    }
}

fn choose<T: Technique>(
    keys: Res<ButtonInput<KeyCode>>,
    mut chosen: ResMut<T>,
    mut diagnostics: ResMut<DiagnosticsStore>,
) {
    let digits = [KeyCode::Digit1, KeyCode::Digit2, KeyCode::Digit3];
    for (digit, choice) in digits.into_iter().zip(T::CHOICES) {
        if keys.just_pressed(digit) {
            *chosen = choice;
            gpu_times::forget(&mut diagnostics);
        }
    }
}

fn write_titles<T: Technique>(chosen: Res<T>, mut panel: ResMut<Panel>) {
    let titles = (1..).zip(T::CHOICES).map(|(key, choice)| {
        let title = choice.title();
        match choice == *chosen {
            true => format!("[{key} {title}]"),
            false => format!("{key} {title}"),
        }
    });
    panel.techniques = titles.collect::<Vec<_>>().join("  ");
}
