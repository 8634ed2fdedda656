//! A walk through a generated level in which features come and go one at a time: lights, shadows, probes, special materials, settings of
//! the camera. For the bench `stutter`, and for tests of what a lean camera shows meanwhile.

mod changes;
mod features;
mod level;

use std::collections::BTreeMap;

use bevy::{
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{PipelineCache, PipelineDescriptor},
    },
};
use bevy_lean_deferred::{
    LeanDeferredPlugins, gbuffer::ForwardReason, lighting::CompiledLighting, prelude::*,
};

pub use features::{FEATURES, Feature};

use crate::{
    device::render_plugin,
    headless::{Headless, small_shadow_maps},
    lean::{active_lean_views, compile_lighting, follows_last_frame},
    renderer::Renderer,
    scenes::{SceneBuilder, build::ambient},
};

/// Metres that the camera walks per frame. The level is long enough for 1,000 frames.
const STRIDE: f32 = 0.04;
/// Height of the camera, in metres.
const EYE: f32 = 1.6;
/// Largest number of features that are present at a time.
const AT_A_TIME: usize = 3;

/// A change of the level or of its camera: the feature with this index comes or goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    Comes(usize),
    Goes(usize),
}

impl Event {
    /// All changes in order. Each feature comes once and goes again.
    pub fn all() -> Vec<Self> {
        let indices: Vec<usize> = (0..FEATURES.len()).collect();
        Self::in_turn(&indices)
    }

    /// As [`Event::all`], for the features with these names alone.
    pub fn of(names: &[&str]) -> Vec<Self> {
        let indices: Vec<usize> = (FEATURES.iter().enumerate())
            .filter(|(_, feature)| names.contains(&feature.name))
            .map(|(index, _)| index)
            .collect();
        assert_eq!(
            indices.len(),
            names.len(),
            "no feature has one of these names: {names:?}"
        );
        Self::in_turn(&indices)
    }

    fn in_turn(indices: &[usize]) -> Vec<Self> {
        let slots = 0..indices.len() + AT_A_TIME - 1;
        let events = slots.flat_map(|slot| {
            let comes = indices.get(slot).map(|index| Self::Comes(*index));
            let goes = slot.checked_sub(AT_A_TIME - 1);
            let goes = goes.map(|slot| Self::Goes(indices[slot]));
            comes.into_iter().chain(goes)
        });
        events.collect()
    }

    /// Name of the feature.
    pub fn feature(self) -> &'static str {
        let (Self::Comes(index) | Self::Goes(index)) = self;
        FEATURES[index].name
    }

    /// Name of the feature, with `comes` or `goes`.
    pub fn name(self) -> String {
        let verb = match self {
            Self::Comes(_) => "comes",
            Self::Goes(_) => "goes",
        };
        format!("{} {verb}", self.feature())
    }
}

/// The level, and the camera that walks through it.
pub struct Walk {
    pub headless: Headless,
    pub camera: Entity,
    renderer: Renderer,
    /// Entities of each feature while it is present.
    entities: Vec<Vec<Entity>>,
    /// Number of features that have come so far.
    came: usize,
    /// Rolls to and fro in front of the camera.
    ball: Entity,
    /// Distance of the camera from its path, in metres.
    aside: f32,
    frames: usize,
}

impl Walk {
    /// The level without any feature, in an app that has this crate's plugins for the lean renderer only.
    pub fn new(renderer: Renderer, size: UVec2, synchronous_compilation: bool) -> Self {
        let mut app = App::new();
        app.add_plugins(Headless::default_plugins().set(render_plugin(synchronous_compilation)));
        if renderer == Renderer::Lean {
            app.add_plugins(LeanDeferredPlugins);
        }
        let mut headless = Headless::from_app(size, app, |app| {
            small_shadow_maps(app);
            if renderer == Renderer::Lean {
                // As apps do by default, and tests do not.
                compile_lighting(app, CompiledLighting::All);
            }
            if renderer == Renderer::BevyDeferred {
                app.insert_resource(DefaultOpaqueRendererMethod::deferred());
            }
        });
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        let ball = level::spawn(&mut s);
        let camera = s.camera(Transform::default(), ambient());
        let world = headless.world();
        renderer.prepare_camera(&mut world.commands().entity(camera));
        world.flush();
        if renderer == Renderer::Lean {
            world
                .entity_mut(camera)
                .insert(LeanForwardMeshes::default());
        }
        Self {
            headless,
            camera,
            renderer,
            entities: vec![Vec::new(); FEATURES.len()],
            came: 0,
            ball,
            aside: 0.0,
            frames: 0,
        }
    }

    /// Gives the camera diffuse GI and reflections.
    pub fn add_effects(&mut self) {
        self.camera_mut().insert((
            LeanScreenSpaceGi::default(),
            LeanScreenSpaceReflections::default(),
        ));
    }

    /// Makes one change. It shows from the next frame on.
    pub fn apply(&mut self, event: Event) {
        match event {
            Event::Comes(index) => {
                self.came += 1;
                let entities = (FEATURES[index].come)(self);
                self.entities[index] = entities;
            }
            Event::Goes(index) => {
                for entity in core::mem::take(&mut self.entities[index]) {
                    self.headless.world().despawn(entity);
                }
                (FEATURES[index].go)(self);
            }
        }
    }

    /// Walks one frame.
    pub fn step(&mut self) {
        self.frames += 1;
        self.place();
        self.headless.frame();
    }

    /// Places the camera and the ball where they are in this frame.
    fn place(&mut self) {
        let time = self.frames as f32;
        let turn = Quat::from_euler(EulerRot::YXZ, 0.15 * (0.05 * time).sin(), -0.15, 0.0);
        let eye = Transform::from_translation(self.ahead(self.aside, EYE, 0.0));
        let ball = Transform::from_translation(self.ahead((0.1 * time).sin(), 0.3, 7.0));
        for (entity, place) in [(self.camera, eye.with_rotation(turn)), (self.ball, ball)] {
            self.headless.world().entity_mut(entity).insert(place);
        }
    }

    /// True if the last frame of the camera was lean.
    pub fn is_lean(&mut self) -> bool {
        active_lean_views(&mut self.headless) == 1
    }

    /// True if the camera has GI and reflections, and the last frame had a valid history for both.
    pub fn follows_last_frame(&mut self) -> bool {
        follows_last_frame(&mut self.headless) == [true; 3]
    }

    /// Meshes that forward drew in the frame before the last, because their pipelines or targets were not ready.
    pub fn waiting_meshes(&mut self) -> usize {
        let camera = self.camera;
        let Some(meshes) = self.headless.world().get::<LeanForwardMeshes>(camera) else {
            return 0;
        };
        let mut counts = meshes.counts.iter();
        counts
            .find(|(reason, _)| *reason == ForwardReason::Compiling)
            .map_or(0, |(_, count)| *count)
    }

    /// Number of pipelines requested so far, by label.
    pub fn requested_pipelines(&self) -> BTreeMap<String, usize> {
        let render_world = self.headless.app.sub_app(RenderApp).world();
        let mut requested = BTreeMap::<String, usize>::new();
        for pipeline in render_world.resource::<PipelineCache>().pipelines() {
            let label = match &pipeline.descriptor {
                PipelineDescriptor::RenderPipelineDescriptor(descriptor) => &descriptor.label,
                PipelineDescriptor::ComputePipelineDescriptor(descriptor) => &descriptor.label,
            };
            let label = label.as_deref().unwrap_or("no label").to_owned();
            *requested.entry(label).or_default() += 1;
        }
        requested
    }

    fn scene(&mut self) -> SceneBuilder<'_> {
        SceneBuilder {
            headless: &mut self.headless,
        }
    }

    fn camera_mut(&mut self) -> EntityWorldMut<'_> {
        let camera = self.camera;
        self.headless.world().entity_mut(camera)
    }

    /// A place at this height, so many metres right of the path and ahead of the camera.
    fn ahead(&self, right: f32, height: f32, distance: f32) -> Vec3 {
        Vec3::new(right, height, -STRIDE * self.frames as f32 - distance)
    }
}
