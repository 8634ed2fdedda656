//! The keys 1, 2 and 3 of examples that compare renderers.

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    prelude::*,
};
use bevy_lean_deferred::LeanDeferred;

use super::{
    keys::{Technique, TechniquePlugin},
    opaque_method::OpaqueMethod,
    panel::PanelCamera,
    switch::switch,
};
use crate::renderer::Renderer;

impl Technique for Renderer {
    const CHOICES: [Self; 3] = [Self::Forward, Self::BevyDeferred, Self::Lean];

    fn title(self) -> &'static str {
        self.name()
    }
}

/// Renders the panel's camera by the renderer that the keys choose; this is the first one.
pub struct RenderersPlugin(pub Renderer);

impl Plugin for RenderersPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(TechniquePlugin(self.0))
            .add_systems(Update, apply.run_if(resource_changed::<Renderer>));
    }
}

fn apply(
    mut commands: Commands,
    renderer: Res<Renderer>,
    camera: Single<Entity, With<PanelCamera>>,
    mut method: OpaqueMethod,
) {
    let is_deferred = *renderer == Renderer::BevyDeferred;
    let mut camera = commands.entity(*camera);
    switch::<LeanDeferred>(&mut camera, *renderer == Renderer::Lean);
    if is_deferred {
        camera.insert((DepthPrepass, DeferredPrepass));
    } else {
        camera.remove::<(DepthPrepass, DeferredPrepass)>();
    }
    method.set(is_deferred);
}
