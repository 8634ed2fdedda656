//! A change makes lean views sort the meshes that it concerns and no others, and Bevy none.

use bevy::{
    core_pipeline::{core_3d::Opaque3d, prepass::MotionVectorPrepass},
    light::NotShadowReceiver,
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems, camera::DirtySpecializations,
        render_phase::ViewBinnedRenderPhases, view::ExtractedView,
    },
};
use bevy_lean_deferred::{gbuffer::SortedMeshes, view::ActiveLeanView};
use kit::{
    headless::Headless,
    lean::{active_lean_views, build, set_lean},
    log_watch,
    own_process::in_own_process,
};

const SIZE: UVec2 = UVec2::new(96, 64);
/// Frames after which a view releases what no mesh needs.
const LINGERING: usize = 121;

/// Requests to Bevy in the last frame: whole lean views, and single meshes, to queue again.
#[derive(Resource, Default, Debug, PartialEq, Eq, Clone, Copy)]
struct AskedOfBevy {
    views: usize,
    meshes: usize,
}

fn note(
    dirty: Res<DirtySpecializations>,
    lean: Query<&ExtractedView, With<ActiveLeanView>>,
    mut asked: ResMut<AskedOfBevy>,
) {
    let is_dirty = |view: &&ExtractedView| dirty.views.contains(&view.retained_view_entity);
    *asked = AskedOfBevy {
        views: lean.iter().filter(is_dirty).count(),
        meshes: dirty.changed_renderables.len(),
    };
}

struct Stage {
    headless: Headless,
    camera: Entity,
    cubes: Vec<Entity>,
    lamp: Entity,
}

fn stage() -> Stage {
    let (mut camera, mut lamp) = (Entity::PLACEHOLDER, Entity::PLACEHOLDER);
    let mut cubes = Vec::new();
    let mut headless = build(SIZE, |s| {
        s.floor();
        for x in -4..=4 {
            for z in -3..=3 {
                let place = Vec3::new(x as f32, 0.3, z as f32);
                cubes.push(s.mesh(
                    Cuboid::from_length(0.5),
                    Color::srgb(0.5, 0.4, 0.3),
                    Transform::from_translation(place),
                ));
            }
        }
        lamp = s.mesh(
            Sphere::new(0.3),
            StandardMaterial {
                emissive: LinearRgba::rgb(1.0, 0.5, 0.2),
                ..default()
            },
            Transform::from_xyz(0.5, 1.0, 0.5),
        );
        s.world().entity_mut(lamp).insert(Visibility::Hidden);
        s.sun(false);
        camera = s.default_camera(());
    });
    headless
        .app
        .sub_app_mut(RenderApp)
        .init_resource::<AskedOfBevy>()
        .add_systems(Render, note.in_set(RenderSystems::Cleanup));
    set_lean(&mut headless, true);
    headless.settle();
    headless.frames(2);
    assert_eq!(active_lean_views(&mut headless), 1);
    Stage {
        headless,
        camera,
        cubes,
        lamp,
    }
}

impl Stage {
    fn entity(&mut self, entity: Entity) -> EntityWorldMut<'_> {
        self.headless.app.world_mut().entity_mut(entity)
    }

    /// For each of the next `frames`: number of meshes that lean views sorted, and the requests to Bevy.
    fn watch(&mut self, frames: usize) -> Vec<(usize, AskedOfBevy)> {
        (0..frames)
            .map(|_| {
                self.headless.frames(1);
                let world = self.headless.app.sub_app(RenderApp).world();
                (
                    world.resource::<SortedMeshes>().0,
                    *world.resource::<AskedOfBevy>(),
                )
            })
            .collect()
    }

    /// Asserts that nothing was requested of Bevy, and that at most `most` meshes were sorted in all.
    fn assert_sorts(&mut self, what: &str, frames: usize, most: usize) {
        let watched = self.watch(frames);
        let sorted: usize = watched.iter().map(|(sorted, _)| sorted).sum();
        assert!(sorted <= most, "{what}: {watched:?}");
        for (_, asked) in watched {
            assert_eq!(asked, AskedOfBevy::default(), "{what}");
        }
    }
}

#[test]
fn each_change_concerns_few_meshes() {
    in_own_process(|| {
        let mut stage = stage();
        stage.assert_sorts("at rest", 5, 0);
        lights_concern_no_mesh(&mut stage);
        a_camera_that_becomes_lean_does_not_trouble_bevy(&mut stage);
        shadow_receivers_concern_themselves(&mut stage);
    });
}

#[test]
#[ignore = "nightly: hundreds of frames for one more kind of change"]
fn an_emissive_mesh_concerns_nobody_else() {
    in_own_process(|| {
        let mut stage = stage();
        let lamp = stage.lamp;
        stage.entity(lamp).insert(Visibility::Visible);
        // When it appears, when its target exists, and while shaders compile.
        stage.assert_sorts("appears", 8, 8);
        stage.entity(lamp).insert(Visibility::Hidden);
        stage.assert_sorts("goes, and its target expires", LINGERING + 4, 1);
        stage.entity(lamp).insert(Visibility::Visible);
        stage.assert_sorts("comes back", 8, 2);
    });
}

fn lights_concern_no_mesh(stage: &mut Stage) {
    let lamp = PointLight {
        shadow_maps_enabled: true,
        ..default()
    };
    let place = Transform::from_xyz(0.0, 3.0, 0.0);
    let world = stage.headless.world();
    // Compiles the shaders for the first light with shadows: until then forward draws.
    let light = world.spawn((lamp, place)).id();
    stage.headless.settle();
    stage.headless.world().despawn(light);
    stage.headless.settle();
    let light = stage.headless.world().spawn((lamp, place)).id();
    stage.assert_sorts("the first light with shadows", 5, 0);
    stage.headless.world().despawn(light);
    stage.headless.settle();
}

#[test]
fn motion_concerns_what_moves() {
    in_own_process(|| {
        let mut stage = stage();
        for _ in 0..2 {
            for cube in stage.cubes.clone() {
                stage
                    .entity(cube)
                    .get_mut::<Transform>()
                    .unwrap()
                    .translation
                    .y += 0.1;
            }
            stage.assert_sorts("without motion vectors", 1, 0);
        }
        let (camera, cube) = (stage.camera, stage.cubes[7]);
        stage.entity(camera).insert(MotionVectorPrepass);
        stage.headless.settle();
        stage.headless.frames(40);
        stage
            .entity(cube)
            .get_mut::<Transform>()
            .unwrap()
            .translation
            .y += 0.1;
        stage.assert_sorts("one starts to move, and stops", 40, 10);
    });
}

fn shadow_receivers_concern_themselves(stage: &mut Stage) {
    let cube = stage.cubes[3];
    stage.entity(cube).insert(NotShadowReceiver);
    stage.assert_sorts("no receiver", 8, 8);
    stage.entity(cube).remove::<NotShadowReceiver>();
    stage.assert_sorts("a receiver again", 8, 2);
}

fn a_camera_that_becomes_lean_does_not_trouble_bevy(stage: &mut Stage) {
    let meshes = stage.cubes.len() + 1;
    set_lean(&mut stage.headless, false);
    stage.headless.settle();
    set_lean(&mut stage.headless, true);
    let watched = stage.watch(4);
    let sorted: Vec<usize> = watched.iter().map(|(sorted, _)| *sorted).collect();
    let all = sorted.iter().sum::<usize>();
    assert!(all <= 2 * meshes, "becomes lean: {sorted:?}");
    for (_, asked) in watched {
        assert_eq!(asked.views, 0, "becomes lean");
    }
    log_watch::assert_validation_layer_silent();
    stage.headless.settle();
}

/// Meshes that are lights as well, one in two, on a camera that becomes lean for the first time: they wait for their pipelines and are then
/// in the G-buffer, like all others. Only such meshes have entities in the render world.
#[test]
fn meshes_that_are_lights_do_not_stay_forward() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            s.floor();
            for n in 0..24 {
                let place = Vec3::new((n % 6) as f32 - 2.5, 0.3, (n / 6) as f32 - 2.0);
                let material = StandardMaterial {
                    emissive: LinearRgba::rgb(1.0, 0.5, 0.1 * n as f32),
                    ..default()
                };
                let mesh = s.mesh(
                    Cuboid::from_length(0.5),
                    material,
                    Transform::from_translation(place),
                );
                if n % 2 == 0 {
                    s.world().entity_mut(mesh).insert(PointLight::default());
                }
            }
            let place = Transform::from_xyz(0.0, 4.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
            s.camera(place, ());
        });
        headless.settle();
        let drawn_forward = |headless: &Headless| {
            let world = headless.app.sub_app(RenderApp).world();
            let phases = world.resource::<ViewBinnedRenderPhases<Opaque3d>>();
            let batches = phases.values().map(|phase| {
                phase.multidrawable_meshes.len()
                    + phase.batchable_meshes.len()
                    + phase.unbatchable_meshes.len()
            });
            batches.sum::<usize>()
        };
        assert!(drawn_forward(&headless) > 0, "the camera is forward");
        set_lean(&mut headless, true);
        headless.frames(2);
        headless.settle();
        headless.frames(4);
        assert_eq!(active_lean_views(&mut headless), 1);
        assert_eq!(drawn_forward(&headless), 0, "batches are left to forward");
        log_watch::assert_validation_layer_silent();
    });
}
