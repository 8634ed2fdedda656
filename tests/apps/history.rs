//! The last frame of a view, for effects that read it.

use bevy::{
    camera::{Hdr, MainPassResolutionOverride, RenderTarget, Viewport},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
    render::{Render, RenderApp, RenderSystems, camera::ExtractedCamera},
};
use bevy_lean_deferred::{
    prelude::*,
    screen_space::{ReadsHistory, ViewHistory},
};
use kit::{
    hdr::read_light,
    headless::{Headless, target_image},
    lean::build,
};

const SIZE: UVec2 = UVec2::new(64, 48);

/// In the render world: whether the views' last frames are read.
#[derive(Resource)]
struct Asks(bool);

fn ask(
    mut commands: Commands,
    asks: Res<Asks>,
    views: Query<Entity, (With<ExtractedCamera>, With<Camera3d>)>,
) {
    for view in &views {
        if asks.0 {
            commands.entity(view).insert(ReadsHistory);
        } else {
            commands.entity(view).remove::<ReadsHistory>();
        }
    }
}

struct Stage {
    headless: Headless,
    camera: Entity,
}

impl Stage {
    fn new() -> Self {
        let mut camera = Entity::PLACEHOLDER;
        let mut headless = build(SIZE, |s| {
            s.solids();
            s.sun(false);
            camera = s.default_camera(LeanDeferred::default());
        });
        headless
            .world()
            .entity_mut(camera)
            .insert(Tonemapping::None);
        let render_app = headless.app.sub_app_mut(RenderApp);
        render_app
            .insert_resource(Asks(true))
            .add_systems(Render, ask.in_set(RenderSystems::PrepareAssets));
        Self { headless, camera }
    }

    fn ask(&mut self, asks: bool) {
        let render_app = self.headless.app.sub_app_mut(RenderApp);
        render_app.insert_resource(Asks(asks));
    }

    /// Makes a frame; whether the view has a history in it, and a valid one.
    fn frame(&mut self) -> Option<bool> {
        self.headless.frame();
        let world = self.headless.app.sub_app_mut(RenderApp).world_mut();
        let mut histories = world.query::<&ViewHistory>();
        let history = histories.iter(world).next()?;
        Some(history.last().is_some())
    }

    /// `change` makes the last frame say nothing of the next one; that one of the frame after it, again.
    fn check_reset(&mut self, name: &str, change: impl FnOnce(&mut EntityWorldMut)) {
        assert_eq!(self.frame(), Some(true), "before {name}");
        let camera = self.camera;
        change(&mut self.headless.world().entity_mut(camera));
        assert_eq!(self.frame(), Some(false), "at {name}");
        assert_eq!(self.frame(), Some(true), "after {name}");
    }
}

#[test]
fn the_last_frame_is_valid_while_one_follows_the_other() {
    let mut stage = Stage::new();
    assert_eq!(stage.frame(), Some(false), "the first frame");
    assert_eq!(stage.frame(), Some(true), "the second frame");

    stage.check_reset("a cut", |camera| {
        camera.insert(CameraCut);
    });
    stage.check_reset("another viewport", |camera| {
        camera.get_mut::<Camera>().unwrap().viewport = Some(Viewport {
            physical_position: UVec2::new(8, 8),
            physical_size: UVec2::new(32, 32),
            ..default()
        });
    });
    // Upscalers ask for one in the render world.
    assert_eq!(stage.frame(), Some(true));
    let world = stage.headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query_filtered::<Entity, With<ExtractedCamera>>();
    let view = views.single(world).expect("one camera");
    world
        .entity_mut(view)
        .insert(MainPassResolutionOverride(UVec2::splat(24)));
    assert_eq!(stage.frame(), Some(false), "at another resolution");
    assert_eq!(stage.frame(), Some(true), "after another resolution");
    let world = stage.headless.app.sub_app_mut(RenderApp).world_mut();
    world
        .entity_mut(view)
        .remove::<MainPassResolutionOverride>();
    assert_eq!(stage.frame(), Some(false), "at the former resolution");
    stage.check_reset("another projection", |camera| {
        camera.insert(Projection::Orthographic(OrthographicProjection {
            scale: 0.1,
            ..OrthographicProjection::default_3d()
        }));
    });
    let larger = target_image(SIZE * 2);
    let larger = stage
        .headless
        .world()
        .resource_mut::<Assets<Image>>()
        .add(larger);
    stage.check_reset("another target", |camera| {
        camera.get_mut::<Camera>().unwrap().viewport = None;
        camera.insert(RenderTarget::from(larger));
    });
    stage.check_reset("another format", |camera| {
        camera.remove::<LeanDeferred>();
        camera.remove::<Hdr>();
    });

    // A pause.
    let camera = stage.camera;
    let set_active = |stage: &mut Stage, is_active| {
        let world = stage.headless.world();
        world.get_mut::<Camera>(camera).unwrap().is_active = is_active;
    };
    set_active(&mut stage, false);
    stage.frame();
    set_active(&mut stage, true);
    assert_eq!(stage.frame(), Some(false), "after a pause");
    assert_eq!(stage.frame(), Some(true));

    // Only what moves goes on.
    stage
        .headless
        .world()
        .get_mut::<Transform>(camera)
        .unwrap()
        .translation
        .x += 0.1;
    assert_eq!(stage.frame(), Some(true), "after a step");
}

#[test]
fn nothing_is_kept_for_nobody() {
    let mut stage = Stage::new();
    stage.frame();
    assert_eq!(stage.frame(), Some(true));
    stage.ask(false);
    assert_eq!(stage.frame(), None, "nobody asks");
    stage.ask(true);
    assert_eq!(stage.frame(), Some(false), "somebody asks again");
    assert_eq!(stage.frame(), Some(true));
    // Depth of several samples cannot be kept.
    let camera = stage.camera;
    let mut camera = stage.headless.world().entity_mut(camera);
    camera.remove::<LeanDeferred>();
    camera.insert(Msaa::Sample4);
    stage.frame();
    assert_eq!(stage.frame(), None, "a multisampled view");
}

#[test]
fn it_holds_what_the_frame_showed() {
    let mut stage = Stage::new();
    stage.headless.settle();
    let pictures = stage.headless.film(3, |world, frame| {
        let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
        for mut camera in cameras.iter_mut(world) {
            camera.translation.x += 0.3 * frame as f32;
        }
    });
    let picture = stage.headless.capture();
    assert!(pictures[1] != picture, "the camera moves");
    let world = stage.headless.app.sub_app_mut(RenderApp).world_mut();
    let mut histories = world.query::<&ViewHistory>();
    let history = histories.iter(world).next().expect("somebody asks");
    let [color, depth] = history.textures().map(Clone::clone);

    let light = read_light(&stage.headless, &color).texels;
    for (i, (light, shown)) in light.iter().zip(picture.rgba.chunks(4)).enumerate() {
        let [red, green, blue] = [light[0], light[1], light[2]].map(|part| part.clamp(0.0, 1.0));
        let srgb = Srgba::from(LinearRgba::rgb(red, green, blue));
        for (kept, shown) in [srgb.red, srgb.green, srgb.blue].into_iter().zip(shown) {
            let off = (kept * 255.0 - f32::from(*shown)).abs();
            assert!(off < 1.5, "pixel {i}: {light:?}, shown as {shown:?}");
        }
    }

    let depth: Vec<f32> = stage
        .headless
        .read(&depth)
        .as_chunks::<4>()
        .0
        .iter()
        .map(|bytes| f32::from_le_bytes(*bytes))
        .collect();
    let geometry = depth.iter().filter(|depth| **depth > 0.0).count();
    let pixels = SIZE.element_product() as usize;
    assert!(depth.iter().all(|depth| (0.0..=1.0).contains(depth)));
    assert!(
        (pixels / 10..pixels * 9 / 10).contains(&geometry),
        "{geometry} of {pixels} pixels have depth"
    );
}
