//! The number of pipelines that draw a mesh into the G-buffer, whatever its camera has.

use bevy::{
    camera::visibility::RenderLayers,
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    prelude::*,
    render::{
        RenderApp,
        occlusion_culling::OcclusionCulling,
        render_resource::{PipelineCache, PipelineDescriptor},
    },
};
use kit::{
    headless::Headless,
    lean::{build, set_lean},
    log_watch,
    own_process::in_own_process,
    skipped::culls_what_is_hidden,
};

const SIZE: UVec2 = UVec2::new(64, 48);
/// Frames after which a view has released targets that no mesh needs.
const LINGERING: usize = 124;

struct Stage {
    headless: Headless,
    camera: Entity,
    cube: Entity,
    lamp: Entity,
    light: Entity,
}

impl Stage {
    fn entity(&mut self, entity: Entity) -> EntityWorldMut<'_> {
        self.headless.app.world_mut().entity_mut(entity)
    }

    fn show_lamp(&mut self, visibility: Visibility) {
        let lamp = self.lamp;
        self.entity(lamp).insert(visibility);
        self.headless.settle();
    }

    fn project(&mut self, projection: impl Into<Projection>) {
        let camera = self.camera;
        self.entity(camera).insert(projection.into());
        self.headless.settle();
    }

    fn move_cube(&mut self) {
        for _ in 0..4 {
            let cube = self.cube;
            let mut cube = self.entity(cube);
            cube.get_mut::<Transform>()
                .expect("it has one")
                .translation
                .y += 0.02;
            self.headless.frame();
        }
        self.headless.settle();
    }

    /// Pipelines of meshes that were requested so far.
    fn pipelines(&self) -> usize {
        let world = self.headless.app.sub_app(RenderApp).world();
        let pipelines = world.resource::<PipelineCache>().pipelines();
        let of_meshes = pipelines.filter(|pipeline| match &pipeline.descriptor {
            PipelineDescriptor::RenderPipelineDescriptor(descriptor) => {
                let label = descriptor.label.as_deref();
                matches!(
                    label,
                    Some("lean_deferred/gbuffer" | "lean_deferred/gbuffer/masked_depth")
                )
            }
            PipelineDescriptor::ComputePipelineDescriptor(_) => false,
        });
        of_meshes.count()
    }

    /// Asserts that `added` pipelines were requested since there were `before`. Returns their number.
    fn expect(&self, before: usize, added: usize, change: &str) -> usize {
        let now = self.pipelines();
        assert_eq!(now - before, added, "{change}");
        now
    }
}

/// Plain, alpha-masked and emissive cubes. The emissive one is hidden.
fn stage() -> Stage {
    let [mut camera, mut cube, mut lamp, mut light] = [Entity::PLACEHOLDER; 4];
    let mut headless = build(SIZE, |s| {
        let place = |x| Transform::from_xyz(x, 0.3, 0.0);
        let color = Color::srgb(0.5, 0.4, 0.3);
        s.mesh(Cuboid::from_length(0.5), color, place(-1.0));
        cube = s.mesh(Cuboid::from_length(0.5), color, place(0.0));
        let leaf = StandardMaterial {
            alpha_mode: AlphaMode::Mask(0.5),
            ..color.into()
        };
        s.mesh(Cuboid::from_length(0.5), leaf, place(1.0));
        let glow = StandardMaterial {
            emissive: LinearRgba::rgb(1.0, 0.5, 0.2),
            ..color.into()
        };
        lamp = s.mesh(Cuboid::from_length(0.5), glow, place(2.0));
        s.world().entity_mut(lamp).insert(Visibility::Hidden);
        light = s.sun(false);
        camera = s.default_camera(RenderLayers::from_layers(&[0, 1]));
    });
    set_lean(&mut headless, true);
    headless.settle();
    Stage {
        headless,
        camera,
        cube,
        lamp,
        light,
    }
}

#[test]
fn a_material_has_few_pipelines() {
    in_own_process(|| {
        let mut stage = stage();
        let (camera, cube, light) = (stage.camera, stage.cube, stage.light);
        let count = stage.expect(0, 3, "plain, and depth and surface of masked");

        stage.project(OrthographicProjection::default_3d());
        let count = stage.expect(count, 0, "an orthographic camera");
        stage.project(PerspectiveProjection::default());
        stage.entity(camera).insert(MotionVectorPrepass);
        stage.headless.settle();
        stage.entity(camera).remove::<MotionVectorPrepass>();
        stage.headless.settle();
        let count = stage.expect(count, 0, "motion vectors, and none again");

        stage.show_lamp(Visibility::Visible);
        let count = stage.expect(
            count,
            3,
            "emissive, and both of masked that clears the valid mask",
        );
        stage.show_lamp(Visibility::Hidden);
        stage.headless.frames(LINGERING);
        stage.show_lamp(Visibility::Visible);
        let count = stage.expect(count, 0, "the lamp again");

        stage.entity(camera).insert(MotionVectorPrepass);
        stage.headless.settle();
        stage.move_cube();
        let count = stage.expect(count, 2, "emissive beside motion, and plain in motion");
        stage.headless.frames(2 * LINGERING);
        stage.entity(camera).remove::<MotionVectorPrepass>();
        stage.headless.settle();
        let count = stage.expect(count, 0, "rest");

        stage.entity(cube).insert(RenderLayers::layer(1));
        stage.entity(light).insert(RenderLayers::layer(0));
        stage.headless.settle();
        let count = stage.expect(count, 2, "emissive beside layers, and plain on a layer");
        stage.entity(cube).remove::<RenderLayers>();
        stage.entity(light).remove::<RenderLayers>();
        stage.headless.settle();
        stage.headless.frames(LINGERING);

        if culls_what_is_hidden(&stage.headless) {
            let culling = (DepthPrepass, OcclusionCulling);
            stage.entity(camera).insert(culling);
            stage.headless.settle();
            stage.expect(count, 1, "plain that clears the valid mask");
        }
        log_watch::assert_validation_layer_silent();
    });
}
