//! The status of each effect on a camera: on, compiling, off with the reason, absent. In processes of their own: compilation is delayed
//! in all of the process, and its log is searched.

use bevy::{
    camera::{Hdr, Viewport},
    core_pipeline::{prepass::DeferredPrepass, schedule::Core2d, tonemapping::Tonemapping},
    log::LogPlugin,
    prelude::*,
    render::{RenderApp, camera::CameraRenderGraph},
};
use bevy_lean_deferred::{LeanDeferredPlugins, effects::auto_exposure::Metering, prelude::*};
use kit::{
    analytic_slabs::{SKIN, slab},
    headless::{Headless, small_shadow_maps},
    log_watch::{self, LogWatch},
    own_process::in_own_process,
    scenes::SceneBuilder,
    skipped::has_room_for_scattering,
    stalled_pipelines::StalledPipelines,
};

const SIZE: UVec2 = UVec2::new(96, 64);

fn all_effects() -> impl Bundle {
    (
        LeanDeferred::default(),
        LeanScreenSpaceAmbientOcclusion::default(),
        LeanScreenSpaceGi::default(),
        LeanScreenSpaceReflections::default(),
        LeanSubsurfaceScattering::default(),
        LeanAutoExposure::default(),
    )
}

/// The statuses of a camera with all effects that run.
fn all_on() -> LeanStatus {
    LeanStatus {
        deferred: EffectStatus::On,
        ambient_occlusion: EffectStatus::Off(LeanOffReason::ReplacedByGi),
        diffuse_gi: EffectStatus::On,
        reflections: EffectStatus::On,
        subsurface: EffectStatus::On,
        auto_exposure: EffectStatus::On,
    }
}

/// The statuses if Bevy renders the camera for this reason.
fn not_lean(reason: LeanOffReason) -> LeanStatus {
    let not_lean = EffectStatus::Off(LeanOffReason::NotLean);
    LeanStatus {
        deferred: EffectStatus::Off(reason),
        ambient_occlusion: EffectStatus::On,
        diffuse_gi: not_lean.clone(),
        reflections: not_lean.clone(),
        subsurface: not_lean,
        auto_exposure: EffectStatus::On,
    }
}

struct Stage {
    headless: Headless,
    camera: Entity,
    ball: Entity,
    scatters: bool,
}

impl Stage {
    fn new(mut headless: Headless) -> Self {
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        s.solids();
        s.sun(true);
        let ball = s.add::<Mesh>(Sphere::new(0.5));
        let skin = s.add::<ExtendedStandardMaterial>(slab(SKIN, 0.05));
        let place = Transform::from_xyz(0.0, 0.5, 2.2);
        let ball = s.spawn((Mesh3d(ball), MeshMaterial3d(skin), place));
        let camera = s.default_camera(());
        let scatters = has_room_for_scattering(&headless.device().limits());
        let mut stage = Self {
            headless,
            camera,
            ball,
            scatters,
        };
        stage.settle();
        stage
    }

    fn settle(&mut self) {
        self.headless.settle();
        self.headless.frames(4);
    }

    fn status(&mut self) -> Option<LeanStatus> {
        let status = self.headless.world().get::<LeanStatus>(self.camera);
        status.cloned()
    }

    /// As [`status`](Self::status), without scattering on devices that do not support it.
    fn comparable(&self, status: LeanStatus) -> LeanStatus {
        if self.scatters {
            return status;
        }
        LeanStatus {
            subsurface: EffectStatus::Absent,
            ..status
        }
    }

    fn change(&mut self, change: impl FnOnce(&mut EntityWorldMut)) {
        change(&mut self.headless.world().entity_mut(self.camera));
    }

    /// Makes `change`, and compares the status once it is settled.
    fn expect(
        &mut self,
        name: &str,
        change: impl FnOnce(&mut EntityWorldMut),
        expected: &LeanStatus,
    ) {
        self.change(change);
        self.settle();
        self.assert_status(name, expected);
    }

    fn assert_status(&mut self, name: &str, expected: &LeanStatus) {
        let status = self.status().expect("it has an effect");
        let [status, expected] = [status, expected.clone()].map(|status| self.comparable(status));
        assert_eq!(status, expected, "{name}");
    }

    /// Makes `change`, after which all effects run.
    fn expect_all(&mut self, change: impl FnOnce(&mut EntityWorldMut)) {
        self.expect("all", change, &all_on());
    }
}

#[test]
fn each_effect_is_on_until_it_is_removed() {
    in_own_process(|| {
        let mut stage = Stage::new(Headless::new(SIZE));
        assert_eq!(stage.status(), None);

        stage.change(|camera| {
            camera.insert(all_effects());
        });
        let status = stage.status().expect("it comes with the effects");
        assert_eq!(status.each().count(), 6);
        let not_rendered = EffectStatus::Off(LeanOffReason::NotRendered);
        assert!(status.each().all(|(_, status)| *status == not_rendered));
        stage.expect_all(|_| {});

        let mut expected = all_on();
        expected.diffuse_gi = EffectStatus::Absent;
        expected.ambient_occlusion = EffectStatus::On;
        stage.expect(
            "without GI",
            |camera| {
                camera.remove::<LeanScreenSpaceGi>();
            },
            &expected,
        );
        expected.ambient_occlusion = EffectStatus::Absent;
        stage.expect(
            "without occlusion",
            |camera| {
                camera.remove::<LeanScreenSpaceAmbientOcclusion>();
            },
            &expected,
        );
        expected.subsurface = EffectStatus::Absent;
        stage.expect(
            "without scattering",
            |camera| {
                camera.remove::<LeanSubsurfaceScattering>();
            },
            &expected,
        );
        expected.deferred = EffectStatus::Absent;
        expected.reflections = EffectStatus::Off(LeanOffReason::NoLeanDeferred);
        stage.expect(
            "without LeanDeferred",
            |camera| {
                camera.remove::<LeanDeferred>();
            },
            &expected,
        );
        expected.reflections = EffectStatus::Absent;
        stage.expect(
            "with exposure alone",
            |camera| {
                camera.remove::<LeanScreenSpaceReflections>();
            },
            &expected,
        );
        stage.change(|camera| {
            camera.remove::<LeanAutoExposure>();
        });
        assert_eq!(stage.status(), None);

        // One that comes back in the same frame.
        stage.change(|camera| {
            camera.insert(LeanDeferred::default());
        });
        stage.settle();
        stage.change(|camera| {
            camera.remove::<LeanDeferred>();
            camera.insert(LeanDeferred::default());
        });
        stage.settle();
        let status = stage.status().expect("it has an effect");
        assert!(status.deferred.is_on(), "{status:?}");
        log_watch::assert_validation_layer_silent();
    });
}

#[test]
fn each_effect_compiles_before_it_is_on() {
    in_own_process(|| {
        let mut stage = Stage::new(Headless::with_compilation(SIZE, false, small_shadow_maps));
        let stalled_pipelines = StalledPipelines::new();
        stage.change(|camera| {
            camera.insert(all_effects());
        });
        stage.headless.frames(3);
        let status = stage.status().expect("it has effects");
        for (component, status) in stage.comparable(status).each() {
            assert_eq!(*status, EffectStatus::Compiling, "{component}");
        }
        drop(stalled_pipelines);
        stage.expect_all(|_| {});

        // Other settings are compiled while the former ones go on.
        let stalled_pipelines = StalledPipelines::new();
        stage.change(|camera| {
            camera.insert((
                LeanScreenSpaceGi {
                    quality: LeanQuality::Low,
                    ..default()
                },
                LeanAutoExposure {
                    metering: Metering::LinearAverage,
                    ..default()
                },
            ));
        });
        stage.headless.frames(3);
        stage.assert_status("other settings", &all_on());
        drop(stalled_pipelines);
        stage.expect_all(|_| {});
    });
}

#[test]
fn each_reason_is_told() {
    in_own_process(|| {
        let mut stage = Stage::new(Headless::new(SIZE));
        stage.change(|camera| {
            camera.insert(all_effects());
        });
        let off = EffectStatus::Off;

        let mut expected = not_lean(LeanOffReason::Msaa);
        expected.ambient_occlusion = off(LeanOffReason::Msaa);
        stage.expect(
            "MSAA",
            |camera| {
                camera.insert(Msaa::Sample4);
            },
            &expected,
        );
        stage.expect_all(|camera| {
            camera.insert(Msaa::Off);
        });

        let mut expected = not_lean(LeanOffReason::NotHdr);
        expected.auto_exposure = off(LeanOffReason::NotHdr);
        stage.expect(
            "no HDR",
            |camera| {
                camera.remove::<Hdr>();
            },
            &expected,
        );
        stage.expect_all(|camera| {
            camera.insert(Hdr);
        });

        let squeeze = |camera: &mut EntityWorldMut| {
            let mut camera = camera.get_mut::<Camera>().expect("it is one");
            camera.viewport = Some(Viewport {
                physical_size: SIZE,
                depth: 0.0..0.5,
                ..default()
            });
        };
        let mut expected = not_lean(LeanOffReason::ViewportDepth);
        expected.ambient_occlusion = off(LeanOffReason::ViewportDepth);
        stage.expect("half of the depth", squeeze, &expected);
        stage.expect_all(|camera| {
            camera.get_mut::<Camera>().expect("it is one").viewport = None;
        });

        stage.expect(
            "Bevy's deferred renderer",
            |camera| {
                camera.insert(DeferredPrepass);
            },
            &not_lean(LeanOffReason::DeferredPrepass),
        );
        stage.expect_all(|camera| {
            camera.remove::<DeferredPrepass>();
        });

        let enable = |is_enabled| {
            move |camera: &mut EntityWorldMut| {
                let mut lean = camera.get_mut::<LeanDeferred>().expect("it has one");
                lean.enabled = is_enabled;
            }
        };
        stage.expect(
            "disabled",
            enable(false),
            &not_lean(LeanOffReason::Disabled),
        );
        stage.expect_all(enable(true));

        let mut expected = all_on();
        expected.auto_exposure = off(LeanOffReason::NoTonemapping);
        stage.expect(
            "no tonemapping",
            |camera| {
                camera.insert(Tonemapping::None);
            },
            &expected,
        );
        stage.expect_all(|camera| {
            camera.insert(Tonemapping::Reinhard);
        });

        // Effects go on behind a debug view.
        for view in [
            DebugView::Normal,
            DebugView::DiffuseLight,
            DebugView::GiLight,
        ] {
            stage.expect_all(|camera| {
                camera.insert(LeanDebugView::from(view));
            });
        }
        stage.expect_all(|camera| {
            camera.remove::<LeanDebugView>();
        });

        let not_rendered = off(LeanOffReason::NotRendered);
        let set_active = |is_active| {
            move |camera: &mut EntityWorldMut| {
                let mut camera = camera.get_mut::<Camera>().expect("it is one");
                camera.is_active = is_active;
            }
        };
        stage.change(set_active(false));
        stage.settle();
        let status = stage.status().expect("it has effects");
        assert!(status.each().all(|(_, status)| *status == not_rendered));
        stage.expect_all(set_active(true));

        let ball = stage.ball;
        stage.headless.world().despawn(ball);
        // Longer than scattering lingers.
        stage.headless.frames(130);
        let mut expected = all_on();
        expected.subsurface = off(LeanOffReason::NothingScatters);
        stage.expect("nothing scatters", |_| {}, &expected);

        // In two dimensions only exposure is left.
        let not_3d = off(LeanOffReason::NotCamera3d);
        let expected = LeanStatus {
            ambient_occlusion: not_3d,
            ..not_lean(LeanOffReason::NotCamera3d)
        };
        stage.expect(
            "two dimensions",
            |camera| {
                camera.remove::<Camera3d>().insert((
                    Camera2d,
                    CameraRenderGraph::new(Core2d),
                    Projection::from(OrthographicProjection::default_2d()),
                    Tonemapping::Reinhard,
                ));
            },
            &expected,
        );
    });
}

/// Missing limits and features of the device, as if `RenderStartup` had detected them.
#[test]
fn what_the_device_lacks_is_told_of_each_effect() {
    in_own_process(|| {
        let mut stage = Stage::new(Headless::new(SIZE));
        let render_world = stage.headless.app.sub_app_mut(RenderApp).world_mut();
        let mut support = render_world.resource_mut::<LeanSupport>();
        let missing = || Err("a lens".to_string());
        support.screen_space = missing();
        support.subsurface = missing();
        support.auto_exposure = missing();
        let off = EffectStatus::Off(LeanOffReason::Device("a lens".into()));
        let expected = LeanStatus {
            deferred: EffectStatus::On,
            ambient_occlusion: EffectStatus::On,
            diffuse_gi: off.clone(),
            reflections: off.clone(),
            subsurface: off.clone(),
            auto_exposure: off,
        };
        stage.expect(
            "all",
            |camera| {
                camera.insert(all_effects());
            },
            &expected,
        );
        for component in [
            "LeanScreenSpaceGi",
            "LeanScreenSpaceReflections",
            "LeanSubsurfaceScattering",
            "LeanAutoExposure",
        ] {
            let text = format!("{component} is off on all cameras: the device lacks a lens");
            let warnings = log_watch::messages_with(&text);
            assert_eq!(warnings.len(), 1, "{warnings:?}");
        }
    });
}

/// A camera that becomes lean is noted once, and again after Bevy has rendered it.
#[test]
fn lean_cameras_are_noted() {
    in_own_process(|| {
        let mut app = App::new();
        let log = LogPlugin {
            filter: "warn,wgpu_hal=error,bevy_lean_deferred=info".into(),
            custom_layer: |_| Some(Box::new(LogWatch)),
            ..default()
        };
        app.add_plugins((Headless::default_plugins().set(log), LeanDeferredPlugins));
        let mut stage = Stage::new(Headless::from_app(SIZE, app, |_| {}));
        let camera = stage.camera;
        let notes = || log_watch::notes_with(&format!("Camera {camera} is lean: 96x64, base"));
        assert_eq!(notes(), [""; 0]);
        stage.change(|camera| {
            camera.insert(LeanDeferred::default());
        });
        stage.settle();
        assert_eq!(notes().len(), 1, "{:?}", notes());
        // One that pauses stays lean.
        for is_active in [false, true] {
            stage.change(|camera| {
                camera.get_mut::<Camera>().expect("it is one").is_active = is_active;
            });
            stage.settle();
        }
        assert_eq!(notes().len(), 1, "{:?}", notes());
        for is_enabled in [false, true] {
            stage.change(|camera| {
                camera.insert(LeanDeferred {
                    enabled: is_enabled,
                    ..default()
                });
            });
            stage.settle();
        }
        assert_eq!(notes().len(), 2, "{:?}", notes());
    });
}
