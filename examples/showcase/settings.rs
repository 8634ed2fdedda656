//! Settings of the panel, and those of pictures.

use bevy::{camera::Exposure, prelude::*};
use kit::{example::panel::cameras, renderer::Renderer};
use street::{Viewpoint, Walking};

use crate::effects::Effect;

/// A viewpoint of the street.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Place {
    #[default]
    Street,
    Stall,
    Puddle,
    Cats,
}

impl Place {
    pub const ALL: [Self; 4] = [Self::Street, Self::Stall, Self::Puddle, Self::Cats];

    pub fn viewpoint(self) -> Viewpoint {
        match self {
            Self::Street => Viewpoint::STREET,
            Self::Stall => Viewpoint::STALL,
            Self::Puddle => Viewpoint::PUDDLE,
            Self::Cats => Viewpoint::CATS,
        }
    }
}

/// Settings of the panel.
#[derive(Component, Reflect, Default)]
#[reflect(Component, Default)]
pub struct Street {
    pub place: Place,
    /// People walk.
    pub walk: bool,
}

/// Lets people walk or stand.
pub fn walk_or_stand(mut commands: Commands, street: Single<&Street, Changed<Street>>) {
    commands.insert_resource(Walking(if street.walk { 1.0 } else { 0.0 }));
}

/// Renderer, effects and place of a picture.
pub struct Settings {
    pub renderer: Renderer,
    /// The active effects, on lean cameras.
    pub effects: Vec<Effect>,
    pub place: Place,
    pub exposure: Exposure,
}

impl Settings {
    pub fn toggle(&mut self, effect: Effect) {
        match self.effects.contains(&effect) {
            true => self.effects.retain(|other| *other != effect),
            false => self.effects.push(effect),
        }
    }

    /// Applies them to the camera.
    pub fn apply(&self, world: &mut World) {
        world.insert_resource(self.renderer);
        for camera in cameras(world) {
            if let Some(mut street) = world.get_mut::<Street>(camera) {
                street.place = self.place;
            }
            let mut commands = world.commands();
            let mut camera = commands.entity(camera);
            camera.insert(self.exposure);
            for effect in Effect::ALL {
                let is_on = self.renderer == Renderer::Lean && self.effects.contains(&effect);
                effect.switch(&mut camera, is_on);
            }
        }
        world.flush();
    }
}
