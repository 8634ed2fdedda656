//! Lean cameras have only the main-pass pipelines of Bevy's compiled that draw their meshes.

use bevy::{
    core_pipeline::prepass::DepthPrepass,
    light::ShadowFilteringMethod,
    pbr::DistanceFog,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{PipelineCache, PipelineDescriptor},
    },
};
use bevy_lean_deferred::prelude::*;
use kit::{
    headless::{Headless, Picture, small_shadow_maps},
    lean::{active_lean_views, judge, report, set_lean, settled},
    log_watch,
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder},
};

const SIZE: UVec2 = UVec2::new(96, 64);
/// More frames than the crate's shaders take to load.
const LOADING: usize = 20;

struct Stage {
    headless: Headless,
    camera: Entity,
}

impl Stage {
    /// A scene with a camera that comes once all shaders are loaded. Compilation is synchronous.
    fn new(is_lean: bool) -> Self {
        let mut headless = Headless::with(SIZE, small_shadow_maps);
        headless.frames(LOADING);
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        s.solids();
        s.sun(true);
        let camera = s.default_camera(());
        if is_lean {
            s.world().entity_mut(camera).insert(LeanDeferred::default());
        }
        Self { headless, camera }
    }

    fn camera(&mut self) -> EntityWorldMut<'_> {
        self.headless.app.world_mut().entity_mut(self.camera)
    }

    fn spawn(&mut self, material: StandardMaterial) {
        let mut s = SceneBuilder {
            headless: &mut self.headless,
        };
        s.mesh(
            Sphere::new(0.4),
            material,
            Transform::from_xyz(0.0, 1.2, 1.8),
        );
    }

    /// Pipelines of Bevy's main passes that were requested so far.
    fn forward_pipelines(&self) -> usize {
        let world = self.headless.app.sub_app(RenderApp).world();
        let pipelines = world.resource::<PipelineCache>().pipelines();
        let of_meshes = pipelines.filter(|pipeline| match &pipeline.descriptor {
            PipelineDescriptor::RenderPipelineDescriptor(descriptor) => {
                let label = descriptor.label.as_deref().unwrap_or_default();
                label.starts_with("pbr_") && label.ends_with("_mesh_pipeline")
            }
            PipelineDescriptor::ComputePipelineDescriptor(_) => false,
        });
        of_meshes.count()
    }

    /// Asserts that the camera is lean, and that no forward pipeline was requested.
    fn assert_lean(&mut self, what: &str) {
        assert_eq!(active_lean_views(&mut self.headless), 1, "{what}");
        assert_eq!(self.forward_pipelines(), 0, "{what}");
    }

    fn picture(&mut self) -> Picture {
        settled(&mut self.headless)
    }
}

/// Neither the first frames of a camera nor changes of it have forward pipelines compiled, where Bevy compiles within the frame.
#[test]
fn meshes_of_the_gbuffer_have_none() {
    in_own_process(|| {
        let mut stage = Stage::new(true);
        stage.headless.frame();
        stage.assert_lean("first frame");
        stage.headless.settle();
        stage.assert_lean("first frames");

        let changes: [(&str, fn(&mut EntityWorldMut)); 4] = [
            ("fog", |camera| {
                camera.insert(DistanceFog::default());
            }),
            ("shadow filter", |camera| {
                camera.insert(ShadowFilteringMethod::Hardware2x2);
            }),
            ("prepass", |camera| {
                camera.insert(DepthPrepass);
            }),
            ("projection", |camera| {
                camera.insert(Projection::from(OrthographicProjection {
                    scale: 0.05,
                    ..OrthographicProjection::default_3d()
                }));
            }),
        ];
        for (name, change) in changes {
            change(&mut stage.camera());
            stage.headless.settle();
            stage.assert_lean(name);
        }

        stage.spawn(StandardMaterial {
            alpha_mode: AlphaMode::Mask(0.5),
            ..default()
        });
        stage.headless.settle();
        stage.assert_lean("a mesh of a new kind");
        log_watch::assert_validation_layer_silent();
    });
}

/// Meshes that are left to Bevy, and all meshes of cameras that are forward again, have theirs.
#[test]
fn meshes_left_to_bevy_have_theirs() {
    in_own_process(|| {
        let blended = || StandardMaterial {
            base_color: Color::srgba(0.2, 0.5, 0.9, 0.5),
            alpha_mode: AlphaMode::Blend,
            ..default()
        };
        let mut forward = Stage::new(false);
        forward.spawn(blended());
        let expected = forward.picture();
        let of_forward = forward.forward_pipelines();

        let mut stage = Stage::new(true);
        stage.headless.settle();
        stage.spawn(blended());
        let lean = stage.picture();
        assert_eq!(stage.forward_pipelines(), 1);
        set_lean(&mut stage.headless, false);
        assert!(stage.picture() == expected, "forward again");
        assert_eq!(stage.forward_pipelines(), of_forward);
        set_lean(&mut stage.headless, true);
        let again = stage.picture();
        assert_eq!(stage.forward_pipelines(), of_forward);
        report([
            judge("left to Bevy", &expected, &lean, LEAST_PSNR),
            judge("lean again", &expected, &again, LEAST_PSNR),
        ]);
    });
}
