//! Cameras of one target: settings that an effect changes on its camera also change on cameras that had the same ones, and are restored.

use bevy::{
    camera::{CameraMainTextureUsages, Hdr, RenderTarget, Viewport},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
    render::render_resource::TextureUsages,
    window::{PrimaryWindow, Window, WindowRef},
};
use bevy_lean_deferred::prelude::*;
use kit::{
    headless::{Headless, target_image},
    log_watch,
    own_process::in_own_process,
};

use crate::actions;

const SIZE: UVec2 = UVec2::new(32, 24);
const BEVYS: (Msaa, bool) = (Msaa::Sample4, false);
const LEAN: (Msaa, bool) = (Msaa::Off, true);

struct Stage {
    headless: Headless,
    /// A target other than the default one of cameras.
    other_target: RenderTarget,
}

impl Stage {
    fn new() -> Self {
        let mut headless = Headless::with(SIZE, actions::add_actions);
        let mut images = headless.world().resource_mut::<Assets<Image>>();
        let other_target = images.add(target_image(SIZE)).into();
        Self {
            headless,
            other_target,
        }
    }

    /// Spawns a camera with Bevy's default settings.
    fn spawn(&mut self, order: isize, bundle: impl Bundle) -> Entity {
        let target = self.headless.render_target();
        let camera = Camera {
            order,
            clear_color: match order {
                0 => ClearColorConfig::Default,
                _ => ClearColorConfig::None,
            },
            ..default()
        };
        let camera = self.headless.world().spawn((camera, target)).id();
        self.act(camera, |camera| {
            camera.insert(bundle);
        });
        camera
    }

    fn act(
        &mut self,
        camera: Entity,
        action: impl FnOnce(&mut EntityCommands) + Send + Sync + 'static,
    ) {
        actions::act(&mut self.headless, camera, action);
        self.headless.frames(1);
    }

    fn insert(&mut self, camera: Entity, bundle: impl Bundle) {
        self.act(camera, |camera| {
            camera.insert(bundle);
        });
    }

    fn remove<B: Bundle>(&mut self, camera: Entity) {
        self.act(camera, |camera| {
            camera.remove::<B>();
        });
    }

    fn set_active(&mut self, camera: Entity, is_active: bool) {
        self.act(camera, move |camera| {
            let mut camera = camera.entry::<Camera>();
            camera.and_modify(move |mut camera| camera.is_active = is_active);
        });
    }

    /// The camera's MSAA, and true if it has `Hdr`.
    fn settings(&mut self, camera: Entity) -> (Msaa, bool) {
        let camera = self.headless.world().entity(camera);
        (*camera.get::<Msaa>().unwrap(), camera.contains::<Hdr>())
    }

    fn assert(&mut self, cameras: &[Entity], expected: (Msaa, bool)) {
        for (index, camera) in cameras.iter().enumerate() {
            assert_eq!(self.settings(*camera), expected, "camera {index}");
        }
    }

    /// True if the camera has a main texture of its own, into which the app's other cameras do not draw.
    fn has_own_texture(&mut self, camera: Entity) -> bool {
        let world = self.headless.world();
        let usages = world.get::<CameraMainTextureUsages>(camera).unwrap();
        usages.0.contains(TextureUsages::COPY_DST)
    }
}

/// A split screen: neither camera draws over the other, so the one without an effect keeps Bevy's settings.
#[test]
fn cameras_beside_one_another_stay_as_they_are() {
    let mut stage = Stage::new();
    let half = UVec2::new(SIZE.x / 2, SIZE.y);
    let cameras = [0, 1].map(|index| {
        let camera = stage.spawn(index, Camera3d::default());
        let physical_position = UVec2::new(half.x * index as u32, 0);
        stage.act(camera, move |camera| {
            camera.entry::<Camera>().and_modify(move |mut camera| {
                camera.viewport = Some(Viewport {
                    physical_position,
                    physical_size: half,
                    ..default()
                });
            });
        });
        camera
    });
    stage.insert(cameras[0], LeanDeferred::default());
    stage.assert(&cameras[..1], LEAN);
    stage.assert(&cameras[1..], BEVYS);
    // Without a viewport, the second camera draws over the first.
    stage.act(cameras[1], |camera| {
        let mut camera = camera.entry::<Camera>();
        camera.and_modify(|mut camera| camera.viewport = None);
    });
    stage.assert(&cameras, LEAN);
}

#[test]
fn what_was_alike_stays_alike() {
    let mut stage = Stage::new();
    let world = stage.spawn(0, Camera3d::default());
    let overlay = stage.spawn(1, Camera2d);
    let weapon = stage.spawn(2, Camera3d::default());
    let all = [world, overlay, weapon];
    let other_target = stage.other_target.clone();
    let elsewhere = stage.spawn(0, (Camera3d::default(), other_target));
    let with_hdr = stage.spawn(3, (Camera3d::default(), Hdr));
    stage.assert(&all, BEVYS);
    for _ in 0..2 {
        for camera in [world, weapon] {
            stage.insert(camera, LeanDeferred::default());
            stage.assert(&all, LEAN);
            stage.remove::<LeanDeferred>(camera);
            stage.assert(&all, BEVYS);
            stage.insert(camera, LeanAmbientOcclusion::default());
            stage.assert(&all, (Msaa::Off, false));
            stage.remove::<LeanAmbientOcclusion>(camera);
            stage.assert(&all, BEVYS);
        }
        for camera in all {
            stage.insert(camera, LeanAutoExposure::default());
            stage.assert(&all, (Msaa::Sample4, true));
            stage.remove::<LeanAutoExposure>(camera);
            stage.assert(&all, BEVYS);
        }
    }
    stage.insert(world, LeanDeferred::default());
    stage.assert(&[elsewhere], BEVYS);
    stage.assert(&[with_hdr], (Msaa::Sample4, true));
    assert!(all.iter().all(|camera| !stage.has_own_texture(*camera)));
}

#[test]
fn what_other_cameras_need_stays() {
    let mut stage = Stage::new();
    let world = stage.spawn(0, (Camera3d::default(), LeanDeferred::default()));
    let overlay = stage.spawn(1, (Camera2d, LeanAutoExposure::default()));
    let third = stage.spawn(2, Camera2d);
    let all = [world, overlay, third];
    stage.assert(&all, LEAN);
    stage.remove::<LeanDeferred>(world);
    stage.assert(&all, (Msaa::Sample4, true));
    stage.remove::<LeanAutoExposure>(overlay);
    stage.assert(&all, BEVYS);

    // In the other order, and both at once.
    stage.insert(overlay, LeanAutoExposure::default());
    stage.insert(world, LeanDeferred::default());
    stage.assert(&all, LEAN);
    stage.remove::<LeanAutoExposure>(overlay);
    stage.assert(&all, LEAN);
    stage.insert(overlay, LeanAutoExposure::default());
    stage
        .headless
        .world()
        .entity_mut(overlay)
        .remove::<LeanAutoExposure>();
    stage.remove::<LeanDeferred>(world);
    stage.assert(&all, BEVYS);
}

#[test]
fn cameras_come_and_go() {
    let mut stage = Stage::new();
    let (here, there) = (stage.headless.render_target(), stage.other_target.clone());
    // The effect exists before its camera, and this camera before the other one.
    let world = stage.headless.world().spawn(LeanDeferred::default()).id();
    stage.headless.frames(1);
    stage.insert(world, (Camera3d::default(), here.clone()));
    let overlay = stage.spawn(1, Camera2d);
    stage.assert(&[world, overlay], LEAN);
    // To another target and back.
    for _ in 0..2 {
        stage.insert(overlay, there.clone());
        stage.assert(&[overlay], BEVYS);
        stage.insert(overlay, here.clone());
        stage.assert(&[overlay], LEAN);
        stage.insert(world, there.clone());
        stage.assert(&[overlay], BEVYS);
        stage.assert(&[world], LEAN);
        stage.insert(world, here.clone());
        stage.assert(&[overlay], LEAN);
    }
    // Inactive cameras share nothing.
    for camera in [world, overlay] {
        stage.set_active(camera, false);
        stage.assert(&[overlay], BEVYS);
        stage.assert(&[world], LEAN);
        stage.set_active(camera, true);
        stage.assert(&[world, overlay], LEAN);
    }
    // From one lean camera to another.
    let another = stage.spawn(0, (Camera3d::default(), there.clone()));
    stage.insert(another, LeanDeferred::default());
    stage.insert(overlay, there);
    stage.assert(&[world, overlay, another], LEAN);
    stage.act(another, |camera| camera.despawn());
    stage.assert(&[overlay], BEVYS);
    stage.insert(overlay, here);
    stage.assert(&[overlay], LEAN);
    stage.remove::<RenderTarget>(overlay);
    stage.assert(&[overlay], BEVYS);
}

#[test]
fn the_primary_window_has_two_names() {
    let mut stage = Stage::new();
    let primary = RenderTarget::Window(WindowRef::Primary);
    let world = stage.spawn(0, (Camera3d::default(), primary));
    stage.insert(world, LeanDeferred::default());
    let overlay = stage.spawn(1, Camera2d);
    let window = stage.headless.world().spawn(Window::default()).id();
    stage.insert(overlay, RenderTarget::Window(WindowRef::Entity(window)));
    stage.assert(&[overlay], BEVYS);
    stage.insert(window, PrimaryWindow);
    stage.assert(&[world, overlay], LEAN);
    stage.remove::<PrimaryWindow>(window);
    stage.assert(&[overlay], BEVYS);
}

#[test]
fn what_the_app_sets_on_others_stays() {
    let mut stage = Stage::new();
    let world = stage.spawn(0, Camera3d::default());
    let overlay = stage.spawn(1, Camera2d);
    let set = |stage: &mut Stage, bundle: fn(&mut EntityCommands), on, off| {
        stage.insert(world, LeanDeferred::default());
        stage.assert(&[overlay], LEAN);
        stage.act(overlay, bundle);
        stage.headless.frames(2);
        stage.assert(&[overlay], on);
        // It remains a partner.
        stage.insert(world, LeanAmbientOcclusion::default());
        stage.assert(&[overlay], on);
        stage.remove::<LeanAmbientOcclusion>(world);
        stage.remove::<LeanDeferred>(world);
        stage.assert(&[overlay], off);
        stage.assert(&[world], BEVYS);
        stage.act(overlay, |overlay| {
            overlay.insert(Msaa::Sample4).remove::<Hdr>();
        });
    };
    let stage = &mut stage;
    set(
        stage,
        |overlay| _ = overlay.insert(Hdr),
        LEAN,
        (Msaa::Sample4, true),
    );
    set(
        stage,
        |overlay| _ = overlay.insert(Msaa::Off),
        LEAN,
        (Msaa::Off, false),
    );
    set(
        stage,
        |overlay| _ = overlay.insert(Msaa::Sample4),
        (Msaa::Sample4, true),
        BEVYS,
    );
    set(
        stage,
        |overlay| _ = overlay.remove::<Hdr>(),
        (Msaa::Off, false),
        BEVYS,
    );

    // A setting that the app removes from the camera with the effect is restored on the others.
    stage.insert(world, LeanDeferred::default());
    stage.insert(world, Msaa::Sample4);
    stage.assert(&[world, overlay], (Msaa::Sample4, true));
    stage.remove::<Hdr>(world);
    stage.assert(&[world, overlay], BEVYS);
}

/// A camera that cleared a main texture of its own, and was blended over others, keeps a texture of its own.
#[test]
fn what_was_not_shared_is_not_shared() {
    let mut stage = Stage::new();
    let world = stage.spawn(0, Camera3d::default());
    let overlay = stage.spawn(1, (Camera2d, Msaa::Off));
    let clears = |clear_color| {
        move |overlay: &mut EntityCommands| {
            let mut camera = overlay.entry::<Camera>();
            camera.and_modify(move |mut camera| camera.clear_color = clear_color);
        }
    };
    // A camera that does not clear may share the texture of the others.
    stage.insert(world, LeanDeferred::default());
    stage.assert(&[overlay], LEAN);
    assert!(!stage.has_own_texture(overlay));
    stage.remove::<LeanDeferred>(world);
    stage.assert(&[overlay], (Msaa::Off, false));

    stage.act(overlay, clears(ClearColorConfig::Custom(Color::NONE)));
    for on_overlay in [false, true] {
        stage.insert(world, LeanDeferred::default());
        if on_overlay {
            stage.insert(overlay, LeanAutoExposure::default());
        }
        stage.assert(&[overlay], LEAN);
        assert!(stage.has_own_texture(overlay) != stage.has_own_texture(world));
        stage.remove::<LeanDeferred>(world);
        stage.remove::<LeanAutoExposure>(overlay);
        stage.assert(&[world], BEVYS);
        stage.assert(&[overlay], (Msaa::Off, false));
        assert!(!stage.has_own_texture(overlay) && !stage.has_own_texture(world));
    }
}

#[test]
fn losses_are_told_once() {
    in_own_process(|| {
        let mut stage = Stage::new();
        let world = stage.spawn(0, Camera3d::default());
        let overlay = stage.spawn(1, Camera2d);
        let weapon = stage.spawn(2, Camera3d::default());
        for _ in 0..3 {
            stage.insert(world, LeanDeferred::default());
            stage.remove::<LeanDeferred>(world);
        }
        let warnings = |camera: Entity, of: &str| {
            let warnings = log_watch::messages_with(of);
            let names = |message: &&String| {
                [camera, world]
                    .iter()
                    .all(|camera| message.contains(&camera.to_string()))
            };
            warnings.iter().filter(names).count()
        };
        assert_eq!(warnings(weapon, "Msaa"), 1);
        assert_eq!(warnings(weapon, "Tonemapping"), 1);
        assert_eq!(warnings(overlay, "camera"), 0);
        // This camera loses nothing.
        let another = stage.spawn(3, (Camera3d::default(), Tonemapping::None, Msaa::Off));
        stage.insert(world, LeanDeferred::default());
        stage.assert(&[another], LEAN);
        assert_eq!(warnings(another, "camera"), 0);
    });
}
