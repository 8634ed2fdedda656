//! `LeanPrewarm`: pipelines are compiled during a loading screen, a few per frame where each delays it, and none is left for later.
//!
//! In processes of their own: they read the log, or take long.

use bevy::{
    anti_alias::taa::TemporalAntiAliasing,
    camera::{Hdr, visibility::Visibility},
    pbr::DistanceFog,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{PipelineCache, PipelineDescriptor},
    },
};
use bevy_lean_deferred::{
    LeanPrewarm, PrewarmFeatures, PrewarmProgress, gbuffer::ForwardReason,
    lighting::CompiledLighting, prelude::*,
};
use kit::{
    gpu,
    headless::{Headless, small_shadow_maps},
    lean::{active_lean_views, compile_lighting, is_lit_by_general},
    log_watch,
    own_process::in_own_process,
    scenes::{SceneBuilder, build::material},
};
use wgpu::Limits;

const SIZE: UVec2 = UVec2::new(96, 64);
/// Most frames until all is compiled.
const PATIENCE: usize = 2000;
/// Pipelines that are requested per frame where each delays it.
const PER_FRAME: usize = 2;
/// Frames for which a shown feature is watched.
const FRAMES_AFTER: usize = 8;

fn app(synchronous: bool) -> Headless {
    Headless::with_compilation(SIZE, synchronous, |app| {
        small_shadow_maps(app);
        compile_lighting(app, CompiledLighting::All);
    })
}

/// Spawns a ball that is not shown, of a material that `change` makes special.
fn hidden_ball(s: &mut SceneBuilder, x: f32, change: impl FnOnce(&mut StandardMaterial)) -> Entity {
    let mut surface = material((0.7, 0.4, 0.3), 0.0, 0.4);
    change(&mut surface);
    let mesh = Sphere::new(0.4).mesh().uv(24, 12);
    let ball = s.mesh(mesh, surface, Transform::from_xyz(x, 0.5, 1.6));
    s.world().entity_mut(ball).insert(Visibility::Hidden);
    ball
}

fn hidden_spot_light(s: &mut SceneBuilder) -> Entity {
    let light = SpotLight {
        intensity: 500_000.0,
        shadow_maps_enabled: true,
        ..default()
    };
    let place = Transform::from_xyz(-2.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y);
    s.spawn((light, place, Visibility::Hidden))
}

/// A camera that is prewarmed for a level, in which some things are hidden.
struct Level {
    headless: Headless,
    camera: Entity,
    lamp: Entity,
    emissive: Entity,
    coated: Entity,
}

impl Level {
    fn new(synchronous: bool, features: Vec<PrewarmFeatures>) -> Self {
        let mut headless = app(synchronous);
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        s.solids();
        s.sun(true);
        let lamp = hidden_spot_light(&mut s);
        let emissive = hidden_ball(&mut s, -1.0, |material| {
            material.emissive = LinearRgba::rgb(0.1, 0.6, 0.3);
        });
        let coated = hidden_ball(&mut s, 1.0, |material| material.clearcoat = 1.0);
        let camera = s.default_camera((
            LeanDeferred::default(),
            LeanForwardMeshes::default(),
            LeanPrewarm {
                features,
                ..default()
            },
        ));
        Self {
            headless,
            camera,
            lamp,
            emissive,
            coated,
        }
    }
}

/// Number of this crate's pipelines that were requested so far.
fn requested(headless: &Headless) -> usize {
    let render_world = headless.app.sub_app(RenderApp).world();
    let pipelines = render_world.resource::<PipelineCache>().pipelines();
    let labels = pipelines.map(|pipeline| match &pipeline.descriptor {
        PipelineDescriptor::ComputePipelineDescriptor(descriptor) => &descriptor.label,
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => &descriptor.label,
    });
    labels
        .filter(|label| (label.as_deref()).is_some_and(|label| label.starts_with("lean_deferred/")))
        .count()
}

fn progress(headless: &mut Headless, camera: Entity) -> PrewarmProgress {
    let prewarm = headless.world().get::<LeanPrewarm>(camera);
    prewarm.expect("it is there").progress
}

/// Runs frames until the prewarm of `camera` is done. Returns how many pipelines were requested in each, from the app's first frame on.
fn finish(headless: &mut Headless, camera: Entity) -> Vec<usize> {
    let mut per_frame = Vec::new();
    let mut before = requested(headless);
    let mut last = PrewarmProgress::default();
    for _ in 0..PATIENCE {
        headless.frame();
        let now = requested(headless);
        per_frame.push(now - before);
        before = now;
        let progress = progress(headless, camera);
        assert!(progress.done >= last.done, "{progress:?} after {last:?}");
        assert!(progress.done <= progress.total, "{progress:?}");
        last = progress;
        if progress.is_done {
            assert_eq!(progress.done, progress.total);
            assert_eq!(progress.fraction(), 1.0);
            return per_frame;
        }
    }
    panic!("{last:?} after {PATIENCE} frames");
}

/// Applies `change`, and runs frames in which nothing is compiled, the camera stays lean and no mesh waits for a pipeline.
fn show(headless: &mut Headless, camera: Entity, name: &str, change: impl FnOnce(&mut World)) {
    let before = requested(headless);
    change(headless.world());
    for frame in 0..FRAMES_AFTER {
        headless.frame();
        assert_eq!(requested(headless), before, "{name}, frame {frame}");
        assert_eq!(active_lean_views(headless), 1, "{name}, frame {frame}");
    }
    let meshes = headless.world().get::<LeanForwardMeshes>(camera);
    let counts = &meshes.expect("it is there").counts;
    let waiting = counts
        .iter()
        .find(|(reason, _)| *reason == ForwardReason::Compiling);
    assert!(waiting.is_none(), "{name}: {waiting:?}");
}

fn show_hidden(headless: &mut Headless, camera: Entity, name: &str, entity: Entity) {
    show(headless, camera, name, |world| {
        world.entity_mut(entity).insert(Visibility::Inherited);
    });
}

/// From the first frame of the app on, so that nothing is compiled before it is counted.
#[test]
fn a_few_pipelines_per_frame_when_synchronous() {
    in_own_process(|| {
        let Level {
            mut headless,
            camera,
            lamp,
            emissive,
            coated,
        } = Level::new(true, Vec::new());
        let per_frame = finish(&mut headless, camera);
        let most = per_frame.iter().max();
        assert!(most <= Some(&PER_FRAME), "{per_frame:?}");
        let all: usize = per_frame.iter().sum();
        let progress = progress(&mut headless, camera);
        assert_eq!(progress.total, all, "{progress:?}");
        // Two general ones of lighting and two that fit the level; meshes that are plain, and of {emissive}, {special}, and both.
        assert!(all >= 8, "{per_frame:?}");
        headless.frame();
        assert!(!is_lit_by_general(&mut headless), "none fits the level");
        for (name, hidden) in [
            ("spot light", lamp),
            ("emissive ball", emissive),
            ("coated ball", coated),
        ] {
            show_hidden(&mut headless, camera, name, hidden);
            assert!(!is_lit_by_general(&mut headless), "{name}");
        }
        show(&mut headless, camera, "fog", |world| {
            world.entity_mut(camera).insert(DistanceFog::default());
        });
        log_watch::assert_validation_layer_silent();
    });
}

/// In the background, nothing is compiled for what the world had or the app named.
#[test]
fn features_that_were_named_compile_nothing() {
    in_own_process(|| {
        let Level {
            mut headless,
            camera,
            lamp,
            emissive,
            ..
        } = Level::new(false, vec![PrewarmFeatures::FOG]);
        finish(&mut headless, camera);
        headless.frame();
        show_hidden(&mut headless, camera, "spot light", lamp);
        show_hidden(&mut headless, camera, "emissive ball", emissive);
        show(&mut headless, camera, "fog", |world| {
            world.entity_mut(camera).insert(DistanceFog::default());
        });
        assert!(!is_lit_by_general(&mut headless), "none fits the fog");
        log_watch::assert_validation_layer_silent();
    });
}

/// Effects are compiled with the settings of the camera, and motion vectors if they are named.
#[test]
fn effects_are_compiled_too() {
    in_own_process(|| {
        let mut headless = app(true);
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        s.solids();
        s.sun(false);
        let camera = s.default_camera((
            LeanDeferred::default(),
            LeanForwardMeshes::default(),
            LeanScreenSpaceGi::default(),
            LeanScreenSpaceReflections::default(),
            LeanPrewarm {
                features: vec![PrewarmFeatures::MOTION_VECTORS],
                ..default()
            },
        ));
        let per_frame = finish(&mut headless, camera);
        let most = per_frame.iter().max();
        assert!(most <= Some(&PER_FRAME), "{per_frame:?}");
        let status = headless.world().get::<LeanStatus>(camera).cloned();
        let status = status.expect("it has effects");
        for (component, status) in status.each() {
            assert!(status.is_on(), "{component}: {status}");
        }
        show(&mut headless, camera, "nothing new", |_| {});
        show(&mut headless, camera, "TAA", |world| {
            let mut camera = world.entity_mut(camera);
            camera.insert(TemporalAntiAliasing::default());
        });
        let ball = headless
            .world()
            .query_filtered::<Entity, With<Mesh3d>>()
            .iter(headless.app.world())
            .last();
        show(&mut headless, camera, "a mesh moves", |world| {
            let ball = ball.expect("there are meshes");
            let mut place = world.get_mut::<Transform>(ball).expect("it has one");
            place.translation.x += 0.1;
        });
        log_watch::assert_validation_layer_silent();
    });
}

/// A second prewarm has nothing to compile, and is done too.
#[test]
fn it_may_be_inserted_again() {
    in_own_process(|| {
        let mut headless = Headless::with_compilation(SIZE, true, small_shadow_maps);
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        s.solids();
        let camera = s.default_camera((LeanDeferred::default(), LeanPrewarm::default()));
        assert!(finish(&mut headless, camera).iter().sum::<usize>() > 0);
        let mut again = headless.world().entity_mut(camera);
        again.insert(LeanPrewarm::default());
        assert_eq!(finish(&mut headless, camera).iter().sum::<usize>(), 0);
        assert_eq!(progress(&mut headless, camera).total, 0);
    });
}

/// A camera that is prewarmed again is not lit by pipelines of its former level, unless they fit.
#[test]
fn former_levels_light_nothing() {
    in_own_process(|| {
        let Level {
            mut headless,
            camera,
            lamp,
            ..
        } = Level::new(false, Vec::new());
        finish(&mut headless, camera);
        // It has no shadow map, so only pipelines of the level light it without being made for it.
        let light = |headless: &mut Headless| {
            let before = requested(headless);
            let lamp = headless.world().spawn((
                SpotLight::default(),
                Transform::from_xyz(-2.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
            ));
            let lamp = lamp.id();
            headless.frames(FRAMES_AFTER);
            headless.world().despawn(lamp);
            headless.frames(FRAMES_AFTER);
            requested(headless) - before
        };
        headless.frames(FRAMES_AFTER);
        assert_eq!(light(&mut headless), 0);

        headless.world().despawn(lamp);
        let mut again = headless.world().entity_mut(camera);
        again.insert(LeanPrewarm::default());
        finish(&mut headless, camera);
        headless.frames(FRAMES_AFTER);
        assert!(light(&mut headless) > 0);
    });
}

/// Messages about prewarms that compile nothing.
fn refusals() -> Vec<String> {
    log_watch::messages_with("LeanPrewarm")
}

#[test]
fn cameras_that_cannot_be_lean_are_done_at_once() {
    in_own_process(|| {
        let mut headless = app(true);
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        let forward = s.default_camera(LeanPrewarm::default());
        headless.frame();
        assert!(progress(&mut headless, forward).is_done);
        let refused = refusals();
        assert_eq!(refused.len(), 1, "{refused:?}");
        assert!(refused[0].contains("`LeanDeferred`"), "{refused:?}");

        let disabled = LeanDeferred {
            enabled: false,
            ..default()
        };
        let mut camera = headless.world().entity_mut(forward);
        camera.insert((disabled, LeanPrewarm::default()));
        headless.frames(4);
        assert!(progress(&mut headless, forward).is_done);
        let refused = refusals();
        assert_eq!(refused.len(), 2, "{refused:?}");
        assert!(
            refused[1].contains("`LeanDeferred::enabled`"),
            "{refused:?}"
        );
    });
}

#[test]
fn on_devices_without_support_it_is_done_at_once() {
    in_own_process(|| {
        let limits = Limits {
            max_storage_textures_per_shader_stage: 3,
            ..gpu::limits()
        };
        let mut headless = Headless::within(limits, SIZE, |_| {});
        let target = headless.render_target();
        let camera = (headless.world()).spawn((
            Camera3d::default(),
            Hdr,
            target,
            LeanDeferred::default(),
            LeanPrewarm::default(),
        ));
        let camera = camera.id();
        headless.frame();
        assert!(progress(&mut headless, camera).is_done);
        let refused = refusals();
        assert_eq!(refused.len(), 1, "{refused:?}");
        assert!(refused[0].contains("storage_textures"), "{refused:?}");
    });
}
