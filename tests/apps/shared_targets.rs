//! Cameras of one target: an effect changes its own camera only, and one warning names a camera that no longer shares its picture.

use bevy::{
    camera::{Hdr, RenderTarget, Viewport},
    prelude::*,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    headless::{Headless, target_image},
    log_watch,
    own_process::in_own_process,
};

const SIZE: UVec2 = UVec2::new(32, 24);
const BEVYS: (Msaa, bool) = (Msaa::Sample4, false);
const LEAN: (Msaa, bool) = (Msaa::Off, true);

struct Stage {
    headless: Headless,
    /// Number of warnings that were asserted so far.
    told: usize,
}

impl Stage {
    /// Spawns two cameras of one target with Bevy's default settings, the second over the first, in place of others.
    fn pair(&mut self, first: impl Bundle, second: impl Bundle) -> [Entity; 2] {
        let target = self.headless.render_target();
        let world = self.headless.world();
        let mut cameras = world.query_filtered::<Entity, With<Camera>>();
        let before: Vec<Entity> = cameras.iter(world).collect();
        for camera in before {
            world.despawn(camera);
        }
        let over = Camera {
            order: 1,
            clear_color: ClearColorConfig::None,
            ..default()
        };
        let first = world.spawn((Camera3d::default(), target.clone(), first));
        let first = first.id();
        let second = world.spawn((Camera3d::default(), over, target, second));
        let cameras = [first, second.id()];
        self.headless.frames(2);
        cameras
    }

    fn change(&mut self, camera: Entity, change: impl FnOnce(&mut EntityWorldMut)) {
        change(&mut self.headless.world().entity_mut(camera));
        self.headless.frames(2);
    }

    fn set_viewport(&mut self, camera: Entity, viewport: Option<URect>) {
        self.change(camera, |camera| {
            let mut camera = camera.get_mut::<Camera>().expect("it is one");
            camera.viewport = viewport.map(|rect| Viewport {
                physical_position: rect.min,
                physical_size: rect.size(),
                ..default()
            });
        });
    }

    /// Asserts the MSAA of each camera, and if it has `Hdr`.
    fn assert_settings(&mut self, cameras: [Entity; 2], expected: [(Msaa, bool); 2]) {
        let settings = cameras.map(|camera| {
            let camera = self.headless.world().entity(camera);
            (*camera.get::<Msaa>().unwrap(), camera.contains::<Hdr>())
        });
        assert_eq!(settings, expected);
    }

    /// Asserts that there was one warning since the last call, which contains `parts`; none if these are empty.
    fn assert_told(&mut self, parts: &[String]) {
        let warnings = log_watch::messages_with("into two textures");
        let new = &warnings[self.told..];
        assert_eq!(new.len(), usize::from(!parts.is_empty()), "{new:?}");
        for warning in new {
            assert!(parts.iter().all(|part| warning.contains(part)), "{new:?}");
        }
        self.told = warnings.len();
    }
}

#[test]
fn cameras_that_share_no_picture_are_told_once() {
    in_own_process(|| {
        let mut stage = Stage {
            headless: Headless::new(SIZE),
            told: 0,
        };
        an_overlap_is_told_once(&mut stage);
        a_camera_below_is_told(&mut stage);
        what_shares_a_picture_is_not_told(&mut stage);
        what_is_missing_is_told(&mut stage);
    });
}

fn an_overlap_is_told_once(stage: &mut Stage) {
    let pair = stage.pair((), ());
    let [world, overlay] = pair;
    // A split screen.
    let half = SIZE.x / 2;
    stage.set_viewport(world, Some(URect::new(0, 0, half, SIZE.y)));
    stage.set_viewport(overlay, Some(URect::new(half, 0, SIZE.x, SIZE.y)));
    stage.change(world, |camera| _ = camera.insert(LeanDeferred::default()));
    stage.assert_settings(pair, [LEAN, BEVYS]);
    stage.assert_told(&[]);

    stage.set_viewport(overlay, None);
    stage.assert_settings(pair, [LEAN, BEVYS]);
    stage.assert_told(&[
        format!("Camera {overlay} draws over camera {world}"),
        "has `Msaa::Off` and `Hdr` for LeanDeferred: ".into(),
        format!("insert `Msaa::Off` and `Hdr` on camera {overlay}"),
    ]);
    for _ in 0..2 {
        stage.change(world, |camera| _ = camera.remove::<LeanDeferred>());
        stage.assert_settings(pair, [BEVYS, BEVYS]);
        stage.change(world, |camera| _ = camera.insert(LeanDeferred::default()));
        stage.assert_settings(pair, [LEAN, BEVYS]);
    }
    stage.assert_told(&[]);
}

fn a_camera_below_is_told(stage: &mut Stage) {
    let pair = stage.pair((), LeanDeferred::default());
    let [world, weapon] = pair;
    stage.assert_settings(pair, [BEVYS, LEAN]);
    stage.assert_told(&[format!("Camera {world} lies under camera {weapon}")]);
}

fn what_shares_a_picture_is_not_told(stage: &mut Stage) {
    let lean = LeanDeferred::default;
    stage.pair((), ());
    stage.pair(lean(), lean());
    // As the warning has it.
    stage.pair(lean(), (Msaa::Off, Hdr));
    // Without an effect that changed something, Bevy's rule is the app's business.
    stage.pair((Msaa::Off, Hdr, lean()), ());
    stage.assert_told(&[]);

    let inactive = Camera {
        is_active: false,
        ..default()
    };
    let [world, _] = stage.pair(inactive, ());
    stage.change(world, |camera| _ = camera.insert(lean()));
    let [world, _] = stage.pair((), ());
    let mut images = stage.headless.world().resource_mut::<Assets<Image>>();
    let elsewhere = RenderTarget::from(images.add(target_image(SIZE)));
    stage.change(world, |camera| _ = camera.insert((lean(), elsewhere)));
    stage.assert_told(&[]);
}

fn what_is_missing_is_told(stage: &mut Stage) {
    let [world, overlay] = stage.pair(LeanScreenSpaceAmbientOcclusion::default(), Hdr);
    stage.assert_told(&[
        format!("camera {world}, which has `Msaa::Off` for LeanScreenSpaceAmbientOcclusion: "),
        format!("insert `Msaa::Off` on camera {overlay}"),
    ]);
    let [world, overlay] = stage.pair(LeanAutoExposure::default(), ());
    stage.assert_told(&[
        format!("camera {world}, which has `Hdr` for LeanAutoExposure: "),
        format!("insert `Hdr` on camera {overlay}"),
    ]);
    let pair = stage.pair(LeanDeferred::default(), (Msaa::Off, Hdr));
    let [_, overlay] = pair;
    stage.change(overlay, |camera| _ = camera.remove::<Hdr>());
    stage.assert_settings(pair, [LEAN, (Msaa::Off, false)]);
    stage.assert_told(&[format!("insert `Hdr` on camera {overlay}")]);
}
