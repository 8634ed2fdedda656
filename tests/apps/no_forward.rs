//! Meshes stay in the G-buffer while pipelines compile that other meshes, or their camera, need.
//!
//! In processes of their own: compilation is delayed in all of the process.

use bevy::{
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    prelude::*,
    render::occlusion_culling::OcclusionCulling,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    headless::Headless, lean::active_lean_views, own_process::in_own_process, scenes::SceneBuilder,
    stalled_pipelines::StalledPipelines,
};

const SIZE: UVec2 = UVec2::new(96, 64);
/// Frames for which compilation is delayed.
const HELD_BACK: usize = 6;
/// Frames after which a view has released targets that no mesh needs.
const LINGERING: usize = 130;

struct Stage {
    headless: Headless,
    camera: Entity,
    /// An emissive mesh, hidden at first.
    lamp: Entity,
    /// Turned in each frame if `moves`.
    cube: Entity,
    moves: bool,
}

impl Stage {
    /// `coated`: some meshes need an optional target from the start.
    fn new(coated: bool, camera: impl Bundle) -> Self {
        let mut headless = Headless::with_compilation(SIZE, false, |_| {});
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        let place = |x, z| Transform::from_xyz(x, 0.3, z);
        let color = Color::srgb(0.5, 0.4, 0.3);
        s.floor();
        for x in [-1.5, -0.5, 0.5] {
            let leaf = StandardMaterial {
                alpha_mode: AlphaMode::Mask(0.5),
                ..color.into()
            };
            s.mesh(Cuboid::from_length(0.5), leaf, place(x, 0.0));
            s.mesh(Cuboid::from_length(0.5), color, place(x, 1.0));
            let coat = StandardMaterial {
                clearcoat: f32::from(coated),
                ..color.into()
            };
            s.mesh(Cuboid::from_length(0.5), coat, place(x, -1.0));
        }
        let cube = s.mesh(Cuboid::from_length(0.5), color, place(1.5, 1.0));
        let glow = StandardMaterial {
            emissive: LinearRgba::rgb(1.0, 0.5, 0.2),
            ..color.into()
        };
        let lamp = s.mesh(Cuboid::from_length(0.5), glow, place(1.5, 0.0));
        s.world().entity_mut(lamp).insert(Visibility::Hidden);
        s.sun(false);
        let camera = s.default_camera((
            LeanDeferred::default(),
            LeanForwardMeshes::default(),
            camera,
        ));
        headless.settle();
        let mut stage = Self {
            headless,
            camera,
            lamp,
            cube,
            moves: false,
        };
        stage.watch("at first", 4, 0);
        stage
    }

    fn entity(&mut self, entity: Entity) -> EntityWorldMut<'_> {
        self.headless.app.world_mut().entity_mut(entity)
    }

    /// Renders frames, and asserts that the camera is lean in each and that forward draws at most `most` meshes.
    fn watch(&mut self, name: &str, frames: usize, most: usize) {
        for frame in 0..frames {
            if self.moves {
                let cube = self.cube;
                let mut cube = self.entity(cube);
                cube.get_mut::<Transform>()
                    .expect("it has one")
                    .rotate_y(0.1);
            }
            self.headless.frame();
            let lean = active_lean_views(&mut self.headless);
            assert_eq!(lean, 1, "{name}, frame {frame}");
            // Of the frame before.
            let meshes = self.headless.world().get::<LeanForwardMeshes>(self.camera);
            let meshes = meshes.expect("the camera has it");
            assert!(meshes.total() <= most, "{name}, frame {frame}: {meshes:?}");
        }
    }

    /// Makes a change while compilation is delayed, and renders until all is compiled.
    fn change(&mut self, name: &str, most: usize, change: impl FnOnce(&mut Self)) {
        let stalled_pipelines = StalledPipelines::new();
        change(self);
        self.watch(name, HELD_BACK, most);
        drop(stalled_pipelines);
        // Pipelines of meshes and of lighting are requested at once: none follows after these.
        while self.headless.is_compiling() {
            self.watch(name, 1, most);
        }
        self.watch(name, 4, most);
        self.watch(name, 4, 0);
    }

    fn set_lamp(&mut self, visibility: Visibility) {
        let lamp = self.lamp;
        self.entity(lamp).insert(visibility);
    }
}

#[test]
fn foliage_stays_lean_when_targets_come_and_go() {
    in_own_process(|| {
        for coated in [false, true] {
            let mut stage = Stage::new(coated, ());
            stage.change("emission comes", 1, |stage| {
                stage.set_lamp(Visibility::Visible);
            });
            stage.change("emission goes", 0, |stage| {
                stage.set_lamp(Visibility::Hidden);
            });
            stage.watch("its target goes", LINGERING, 0);
            stage.change("emission again", 1, |stage| {
                stage.set_lamp(Visibility::Visible);
            });
        }
    });
}

#[test]
fn meshes_stay_lean_when_motion_vectors_come_and_go() {
    in_own_process(|| {
        for moves in [false, true] {
            let mut stage = Stage::new(true, ());
            stage.moves = moves;
            let camera = stage.camera;
            stage.change("motion vectors", 0, |stage| {
                let prepasses = (DepthPrepass, MotionVectorPrepass);
                stage.entity(camera).insert(prepasses);
            });
            stage.change("none", 0, |stage| {
                let mut camera = stage.entity(camera);
                camera.remove::<(DepthPrepass, MotionVectorPrepass)>();
            });
        }
    });
}

/// All meshes then clear the valid mask, from the frame on in which there is an optional target.
#[test]
fn two_phase_culling_keeps_meshes_lean() {
    in_own_process(|| {
        for coated in [false, true] {
            let mut stage = Stage::new(coated, (DepthPrepass, OcclusionCulling));
            stage.change("emission comes", 1, |stage| {
                stage.set_lamp(Visibility::Visible);
            });
            stage.set_lamp(Visibility::Hidden);
            stage.watch("emission goes", LINGERING, 0);
        }
    });
}
