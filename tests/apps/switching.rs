//! Effects added and removed at run time: cameras get their own settings back, report their status, and are warned about again.

use core::time::Duration;
use std::time::Instant;

use bevy::{
    camera::{Hdr, RenderTarget},
    core_pipeline::prepass::DeferredPrepass,
    post_process::bloom::Bloom,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{CachedPipeline, PipelineCache, PipelineDescriptor},
    },
};
use bevy_lean_deferred::{LeanDeferredPlugins, lean::LeanDeferredSupport, prelude::*};
use kit::{
    device::render_plugin, headless::Headless, lean::active_lean_views, log_watch,
    own_process::in_own_process, scenes::SceneBuilder,
};

use crate::actions::{self, Action};

const SIZE: UVec2 = UVec2::new(96, 64);
/// Longer than shaders take to compile.
const PATIENCE: Duration = Duration::from_secs(100);

struct Stage {
    headless: Headless,
    /// A camera with Bevy's default settings.
    camera: Entity,
}

impl Stage {
    fn new() -> Self {
        Self::with(true)
    }

    fn with(synchronous_pipeline_compilation: bool) -> Self {
        let mut app = App::new();
        app.add_plugins((
            Headless::default_plugins().set(render_plugin(synchronous_pipeline_compilation)),
            LeanDeferredPlugins,
        ));
        let mut headless = Headless::from_app(SIZE, app, actions::add_actions);
        let mut scene = SceneBuilder {
            headless: &mut headless,
        };
        scene.solids();
        scene.sun(true);
        let camera = spawn_camera(&mut scene);
        Self { headless, camera }
    }

    /// Replaces the camera by another with Bevy's default settings.
    fn replace_camera(&mut self) {
        self.headless.world().despawn(self.camera);
        let mut scene = SceneBuilder {
            headless: &mut self.headless,
        };
        self.camera = spawn_camera(&mut scene);
    }

    fn act(&mut self, action: impl FnOnce(&mut EntityCommands) + Send + Sync + 'static) {
        actions::act(&mut self.headless, self.camera, action);
        self.headless.frames(3);
        let errors = log_watch::messages_with("Caught rendering error");
        assert!(errors.is_empty(), "{errors:?}");
    }

    fn add<E: Component + Default>(&mut self) {
        self.act(|camera| {
            camera.insert(E::default());
        });
    }

    fn remove<E: Bundle>(&mut self) {
        self.act(|camera| {
            camera.remove::<E>();
        });
    }

    fn insert(&mut self, bundle: impl Bundle) {
        self.act(|camera| {
            camera.insert(bundle);
        });
    }

    /// The camera's MSAA, and true if it has `Hdr`.
    fn settings(&mut self) -> (Msaa, bool) {
        let camera = self.headless.world().entity(self.camera);
        (*camera.get::<Msaa>().unwrap(), camera.contains::<Hdr>())
    }

    fn status(&mut self) -> Option<LeanStatus> {
        self.headless.world().get(self.camera).cloned()
    }

    /// Number of pipelines with this label.
    fn pipelines(&self, label: &str) -> usize {
        let render_world = self.headless.app.sub_app(RenderApp).world();
        let pipelines = render_world.resource::<PipelineCache>().pipelines();
        pipelines
            .filter(|pipeline| label_of(pipeline) == Some(label))
            .count()
    }
}

fn spawn_camera(scene: &mut SceneBuilder) -> Entity {
    let target = scene.headless.render_target();
    scene.spawn((
        Camera3d::default(),
        target,
        Transform::from_xyz(-1.5, 2.8, 5.2).looking_at(Vec3::ZERO, Vec3::Y),
    ))
}

fn label_of(pipeline: &CachedPipeline) -> Option<&str> {
    match &pipeline.descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => descriptor.label.as_deref(),
        PipelineDescriptor::ComputePipelineDescriptor(descriptor) => descriptor.label.as_deref(),
    }
}

const BEVYS: (Msaa, bool) = (Msaa::Sample4, false);

#[test]
fn settings_are_given_back() {
    let mut stage = Stage::new();
    what_an_effect_changed_is_given_back(&mut stage);
    stage.replace_camera();
    what_another_effect_needs_stays(&mut stage);
    stage.replace_camera();
    what_the_app_set_stays(&mut stage);
}

fn what_an_effect_changed_is_given_back(stage: &mut Stage) {
    stage.headless.settle();
    let before = stage.headless.capture();
    assert_eq!(stage.settings(), BEVYS);

    for _ in 0..2 {
        stage.add::<LeanDeferred>();
        assert_eq!(stage.settings(), (Msaa::Off, true));
        assert_eq!(active_lean_views(&mut stage.headless), 1);
        stage.remove::<LeanDeferred>();
        assert_eq!(stage.settings(), BEVYS);

        stage.add::<LeanAmbientOcclusion>();
        assert_eq!(stage.settings(), (Msaa::Off, false));
        stage.remove::<LeanAmbientOcclusion>();
        assert_eq!(stage.settings(), BEVYS);

        stage.add::<LeanAutoExposure>();
        assert_eq!(stage.settings(), (Msaa::Sample4, true));
        stage.remove::<LeanAutoExposure>();
        assert_eq!(stage.settings(), BEVYS);
    }
    stage.headless.settle();
    assert!(stage.headless.capture() == before);
}

fn what_another_effect_needs_stays(stage: &mut Stage) {
    stage.add::<LeanAmbientOcclusion>();
    stage.add::<LeanDeferred>();
    stage.remove::<LeanAmbientOcclusion>();
    assert_eq!(stage.settings(), (Msaa::Off, true));
    stage.add::<LeanAmbientOcclusion>();
    stage.remove::<LeanDeferred>();
    assert_eq!(stage.settings(), (Msaa::Off, false));
    stage.remove::<LeanAmbientOcclusion>();
    assert_eq!(stage.settings(), BEVYS);

    stage.add::<LeanDeferred>();
    stage.add::<LeanAutoExposure>();
    stage.remove::<LeanDeferred>();
    assert_eq!(stage.settings(), (Msaa::Sample4, true));
    stage.remove::<LeanAutoExposure>();
    assert_eq!(stage.settings(), BEVYS);

    // Bevy's bloom requires `Hdr` too.
    stage.add::<LeanDeferred>();
    stage.add::<Bloom>();
    stage.remove::<LeanDeferred>();
    assert_eq!(stage.settings(), (Msaa::Sample4, true));

    // All at once.
    stage.remove::<(Bloom, Hdr)>();
    stage.insert((
        LeanDeferred::default(),
        LeanAmbientOcclusion::default(),
        LeanAutoExposure::default(),
    ));
    assert_eq!(stage.settings(), (Msaa::Off, true));
    stage.act(|camera| {
        camera.remove::<(LeanDeferred, LeanAmbientOcclusion, LeanAutoExposure)>();
    });
    assert_eq!(stage.settings(), BEVYS);
}

fn what_the_app_set_stays(stage: &mut Stage) {
    // Not every device supports 2 or 8 samples, so nothing is rendered.
    stage.remove::<RenderTarget>();

    // Set before the effect is added.
    stage.insert((Hdr, Msaa::Off));
    stage.add::<LeanDeferred>();
    stage.remove::<LeanDeferred>();
    assert_eq!(stage.settings(), (Msaa::Off, true));
    stage.remove::<Hdr>();

    // Set together with the effect.
    stage.insert((Hdr, Msaa::Sample2, LeanDeferred::default()));
    assert_eq!(stage.settings(), (Msaa::Off, true));
    stage.remove::<LeanDeferred>();
    assert_eq!(stage.settings(), (Msaa::Sample2, true));
    stage.remove::<Hdr>();

    // The effect exists before the camera.
    stage.remove::<(Camera3d, Camera, Msaa)>();
    stage.add::<LeanDeferred>();
    stage.add::<Camera3d>();
    assert_eq!(stage.settings(), (Msaa::Off, true));
    stage.remove::<LeanDeferred>();
    assert_eq!(stage.settings(), BEVYS);

    // Set after the effect is added.
    stage.add::<LeanDeferred>();
    stage.insert((Hdr, Msaa::Sample8));
    stage.remove::<LeanDeferred>();
    assert_eq!(stage.settings(), (Msaa::Sample8, true));
    stage.remove::<Hdr>();
    stage.add::<LeanDeferred>();
    stage.insert(Msaa::Off);
    stage.remove::<LeanDeferred>();
    assert_eq!(stage.settings(), (Msaa::Off, false));
    stage.insert(Msaa::Sample4);
    stage.add::<LeanDeferred>();
    stage.act(|camera| {
        camera
            .entry::<Msaa>()
            .and_modify(|mut msaa| *msaa = Msaa::Off);
    });
    stage.remove::<LeanDeferred>();
    assert_eq!(stage.settings(), (Msaa::Off, false));

    // Removed after the effect is added.
    stage.add::<LeanDeferred>();
    stage.remove::<Hdr>();
    stage.remove::<LeanDeferred>();
    assert_eq!(stage.settings(), (Msaa::Off, false));
}

#[test]
fn the_status_tells_what_the_camera_does() {
    let mut stage = Stage::with(false);
    stage.headless.frames(3);
    assert_eq!(stage.status(), None);

    // Forward draws until the shaders are compiled.
    let camera = stage.camera;
    let world = stage.headless.world();
    world.entity_mut(camera).insert(LeanDeferred::default());
    let not_rendered = LeanStatus::Off(LeanOffReason::NotRendered);
    assert_eq!(stage.status(), Some(not_rendered.clone()));
    let mut seen = Vec::new();
    let start = Instant::now();
    while seen.last() != Some(&LeanStatus::Lean) {
        let was_active = active_lean_views(&mut stage.headless) == 1;
        stage.headless.frames(1);
        let status = stage.status().unwrap();
        assert_eq!(was_active, status == LeanStatus::Lean, "{status}");
        assert!(start.elapsed() < PATIENCE, "{status}");
        if seen.last() != Some(&status) {
            seen.push(status);
        }
    }
    assert_eq!(
        seen,
        [
            not_rendered.clone(),
            LeanStatus::Compiling,
            LeanStatus::Lean
        ]
    );

    let mut expect = |bundle: Action, status: LeanStatus| {
        actions::queue(&mut stage.headless, bundle);
        let start = Instant::now();
        while stage.status().as_ref() != Some(&status) {
            assert!(start.elapsed() < PATIENCE, "{:?}", stage.status());
            stage.headless.frames(1);
        }
    };
    let off = LeanStatus::Off;
    expect(
        Box::new(move |commands| {
            commands.entity(camera).insert(Msaa::Sample4);
        }),
        off(LeanOffReason::Msaa),
    );
    expect(
        Box::new(move |commands| {
            commands.entity(camera).insert(Msaa::Off).remove::<Hdr>();
        }),
        off(LeanOffReason::NotHdr),
    );
    let set_active = |is_active| -> Action {
        Box::new(move |commands| {
            let mut camera = commands.entity(camera);
            camera
                .entry::<Camera>()
                .and_modify(move |mut camera| camera.is_active = is_active);
        })
    };
    expect(set_active(false), not_rendered);
    expect(set_active(true), off(LeanOffReason::NotHdr));
    expect(
        Box::new(move |commands| {
            commands.entity(camera).insert(Hdr);
        }),
        LeanStatus::Lean,
    );

    let render_app = stage.headless.app.sub_app_mut(RenderApp);
    render_app.insert_resource(LeanDeferredSupport::Missing("a storage texture".into()));
    stage.headless.frames(2);
    let status = stage.status().unwrap();
    assert_eq!(
        status.to_string(),
        "off: the device lacks a storage texture"
    );

    stage.remove::<LeanDeferred>();
    assert_eq!(stage.status(), None);
}

fn warnings(effect: &str, reason: &str) -> usize {
    log_watch::messages_with(&format!("{effect} on camera "))
        .iter()
        .filter(|message| message.contains(reason))
        .count()
}

#[test]
fn warnings_come_again_when_the_cause_does() {
    in_own_process(|| {
        let mut stage = Stage::new();
        let lean = || warnings("LeanDeferred", "it has `DeferredPrepass`");
        stage.add::<LeanDeferred>();
        for expected in 1..=2 {
            stage.add::<DeferredPrepass>();
            assert_eq!(lean(), expected);
            // The reason is kept while the camera is inactive.
            for is_active in [false, true] {
                stage.act(move |camera| {
                    camera
                        .entry::<Camera>()
                        .and_modify(move |mut camera| camera.is_active = is_active);
                });
            }
            assert_eq!(lean(), expected);
            stage.remove::<DeferredPrepass>();
        }
        stage.remove::<LeanDeferred>();
        stage.insert((LeanDeferred::default(), DeferredPrepass));
        assert_eq!(lean(), 3);
        stage.remove::<(LeanDeferred, DeferredPrepass)>();
        stage.insert((LeanDeferred::default(), DeferredPrepass));
        assert_eq!(lean(), 4, "it was forgotten with the component");
        stage.remove::<(LeanDeferred, DeferredPrepass)>();

        let occlusion = || warnings("LeanAmbientOcclusion", "its `Msaa` is not `Off`");
        stage.add::<LeanAmbientOcclusion>();
        for expected in 1..=2 {
            stage.insert(Msaa::Sample4);
            assert_eq!(occlusion(), expected);
            stage.insert(Msaa::Off);
        }
        let exposure = || warnings("LeanAutoExposure", "it has no `Hdr`");
        stage.add::<LeanAutoExposure>();
        for expected in 1..=2 {
            stage.remove::<Hdr>();
            assert_eq!(exposure(), expected);
            stage.insert(Hdr);
        }
        assert_eq!(occlusion(), 2);
    });
}

#[test]
fn animated_quality_compiles_one_pipeline() {
    let mut stage = Stage::new();
    let occlusion = |quality| LeanAmbientOcclusion {
        quality,
        intensity: 3.0,
        ..default()
    };
    stage.insert(occlusion(OcclusionQuality::High));
    stage.headless.settle();
    let preset = stage.headless.capture();
    let compiled = stage.pipelines("lean_deferred/ambient_occlusion/gather");
    assert_eq!(compiled, 1);
    for steps in 1..=12 {
        stage.insert(occlusion(OcclusionQuality::Custom { slices: 2, steps }));
    }
    let compiled = stage.pipelines("lean_deferred/ambient_occlusion/gather");
    assert_eq!(compiled, 2);

    stage.insert(occlusion(OcclusionQuality::Custom {
        slices: 2,
        steps: 8,
    }));
    stage.headless.settle();
    let custom = kit::metrics::difference(&preset, &stage.headless.capture());
    assert!(custom.largest <= 1, "{custom}");
}
