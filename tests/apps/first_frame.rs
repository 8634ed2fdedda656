//! The first frame of a camera, ever or after a pause: portals, surveillance screens, minimaps and thumbnails render one frame in several.
//! It is lean, and equals the frame of a camera that is always active.

use bevy::{
    camera::{RenderTarget, visibility::RenderLayers},
    prelude::*,
    render::{RenderApp, sync_world::MainEntity},
};
use bevy_lean_deferred::{
    effects::{ambient_occlusion::ActiveOcclusion, subsurface::ActiveScattering},
    gbuffer::GBufferTargets,
    prelude::*,
    view::ActiveLeanView,
};
use kit::{
    analytic_slabs::{SKIN, slab},
    headless::{Headless, Picture, target_image},
    lean::build,
    log_watch,
    metrics::pixel_difference,
    scenes::{SceneBuilder, build::default_camera_transform},
};

const SIZE: UVec2 = UVec2::new(96, 64);

/// Settings whose lean picture differs visibly from Bevy's forward one.
fn effects() -> impl Bundle {
    (
        LeanDeferred::default(),
        LeanScreenSpaceAmbientOcclusion {
            intensity: 3.0,
            ..default()
        },
        LeanSubsurfaceScattering::default(),
    )
}

struct Stage {
    headless: Headless,
    always_on: Entity,
    screens: [Handle<Image>; 2],
    transform: Transform,
}

impl Stage {
    fn new() -> Self {
        let mut headless = build(SIZE, |s| {
            s.solids();
            s.sun(true);
            s.mesh(
                Sphere::new(0.4),
                StandardMaterial {
                    clearcoat: 1.0,
                    emissive: LinearRgba::rgb(0.2, 0.1, 0.3),
                    ..default()
                },
                Transform::from_xyz(0.0, 0.4, 1.6),
            );
            let ball = s.add::<Mesh>(Sphere::new(0.5));
            let skin = s.add::<ExtendedStandardMaterial>(slab(SKIN, 0.05));
            let place = Transform::from_xyz(-1.2, 0.5, 1.8);
            s.spawn((Mesh3d(ball), MeshMaterial3d(skin), place));
        });
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        let screens = [0, 1].map(|_| s.add::<Image>(target_image(SIZE)));
        let transform = default_camera_transform();
        let always_on = s.camera(transform, effects());
        let mut stage = Self {
            headless,
            always_on,
            screens,
            transform,
        };
        stage
            .headless
            .world()
            .entity_mut(always_on)
            .insert(RenderTarget::from(stage.screens[0].clone()));
        stage.headless.settle();
        stage
    }

    /// Spawns a camera on the other screen.
    fn spawn(&mut self, order: isize) -> Entity {
        let mut s = SceneBuilder {
            headless: &mut self.headless,
        };
        let camera = s.camera(self.transform, effects());
        let screen = RenderTarget::from(self.screens[1].clone());
        let order = Camera { order, ..default() };
        self.headless
            .world()
            .entity_mut(camera)
            .insert((screen, order));
        camera
    }

    fn set_active(&mut self, camera: Entity, is_active: bool) {
        let mut camera = self.headless.world().get_mut::<Camera>(camera).unwrap();
        camera.is_active = is_active;
    }

    fn pictures(&self) -> [Picture; 2] {
        let [one, other] = &self.screens;
        [one, other].map(|screen| self.headless.picture_of(screen))
    }

    /// The targets of `camera` in the last frame, and true for each of occlusion and scattering if active; none unless it was lean.
    fn state(&mut self, camera: Entity) -> Option<(GBufferTargets, bool, bool)> {
        let world = self.headless.app.sub_app_mut(RenderApp).world_mut();
        let mut views = world.query::<(
            &MainEntity,
            &ActiveLeanView,
            Has<ActiveOcclusion>,
            Has<ActiveScattering>,
        )>();
        views
            .iter(world)
            .find(|(main, ..)| main.id() == camera)
            .map(|(_, view, occlusion, scattering)| (view.targets, occlusion, scattering))
    }

    fn check(&mut self, name: &str, camera: Entity) {
        let expected = self.state(self.always_on);
        assert!(expected.is_some_and(|(targets, ..)| !targets.is_empty()));
        assert_eq!(self.state(camera), expected, "{name}");
        let [expected, found] = self.pictures();
        let difference = pixel_difference(&expected, &found);
        println!("{name}: {difference}");
        assert!(difference.psnr > 70.0, "{name}: {difference}");
    }
}

#[test]
fn one_frame_in_four_is_lean() {
    let mut stage = Stage::new();
    let camera = stage.spawn(1);
    stage.headless.settle();
    stage.headless.frames(3);
    stage.check("always", camera);
    for round in 0..3 {
        stage.set_active(camera, false);
        stage.headless.frames(3);
        // Another view in between, so that an old picture would show.
        let turn = Quat::from_rotation_y(0.4 * (round + 1) as f32);
        stage.transform = default_camera_transform();
        stage.transform.rotate_around(Vec3::ZERO, turn);
        for entity in [camera, stage.always_on] {
            *stage.headless.world().get_mut::<Transform>(entity).unwrap() = stage.transform;
        }
        stage.set_active(camera, true);
        stage.headless.frames(1);
        stage.check(&format!("round {round}"), camera);
    }
    log_watch::assert_validation_layer_silent();
}

/// A camera that pauses again and again keeps its demands for as many of its own frames as any other.
#[test]
#[ignore = "nightly: 500 frames of the pauses that the first test has"]
fn demands_outlast_pauses() {
    let mut stage = Stage::new();
    let camera = stage.spawn(1);
    stage.headless.settle();
    for _ in 0..130 {
        stage.set_active(camera, false);
        stage.headless.frames(1);
        stage.set_active(camera, true);
        stage.headless.frames(1);
    }
    stage.check("after 130 pauses", camera);
    // Demands of meshes out of sight expire as elsewhere.
    stage
        .headless
        .world()
        .entity_mut(camera)
        .insert(RenderLayers::layer(5));
    for _ in 0..125 {
        stage.set_active(camera, false);
        stage.headless.frames(1);
        stage.set_active(camera, true);
        stage.headless.frames(1);
    }
    let (targets, ..) = stage.state(camera).unwrap();
    assert_eq!(targets, GBufferTargets::empty());
}

/// Without any other camera, the first frame has the targets of the last camera there was: no mesh is missing in a thumbnail, or in the
/// first frame after a menu.
#[test]
fn a_camera_spawned_anew_has_the_targets_of_the_last() {
    let mut stage = Stage::new();
    let only = stage.spawn(1);
    stage.headless.settle();
    stage.headless.frames(2);
    let expected = stage.state(only);
    let [_, before] = stage.pictures();
    for camera in [only, stage.always_on] {
        stage.headless.world().despawn(camera);
    }
    stage.headless.frames(3);
    for round in 0..2 {
        let camera = stage.spawn(1);
        stage.headless.frames(1);
        assert_eq!(stage.state(camera), expected, "round {round}");
        let [_, now] = stage.pictures();
        let difference = pixel_difference(&before, &now);
        assert!(difference.psnr > 70.0, "round {round}: {difference}");
        stage.headless.world().despawn(camera);
        stage.headless.frames(3);
    }
}

/// A camera spawned for one frame is lean: its pipelines were compiled for other cameras.
#[test]
fn a_camera_that_lives_for_one_frame_is_lean() {
    let mut stage = Stage::new();
    // Bevy creates a target's pipeline when the target is first drawn to.
    let first = stage.spawn(1);
    stage.headless.settle();
    stage.headless.world().despawn(first);
    stage.headless.frames(2);
    let camera = stage.spawn(1);
    stage.headless.frames(1);
    stage.check("thumbnail", camera);
    stage.headless.world().despawn(camera);
    stage.headless.frames(2);
}
