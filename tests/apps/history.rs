//! The last frame of a view, kept for effects that read it.

use bevy::{
    camera::{MainPassResolutionOverride, RenderTarget, Viewport},
    core_pipeline::tonemapping::Tonemapping,
    math::Vec4Swizzles,
    prelude::*,
    render::{Render, RenderApp, RenderSystems, camera::ExtractedCamera},
};
use bevy_lean_deferred::{
    effects::{ReadsHistory, ViewHistory},
    prelude::*,
};
use kit::{
    hdr::read_light,
    headless::{Headless, target_image},
    lean::build,
};

const SIZE: UVec2 = UVec2::new(64, 48);

/// In the render world: true while effects request the views' last frames.
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
        let mut stage = Self { headless, camera };
        // The pipelines that keep a frame compile on the first request.
        stage.headless.settle();
        stage.ask(false);
        stage.frame();
        stage.ask(true);
        stage
    }

    fn ask(&mut self, asks: bool) {
        let render_app = self.headless.app.sub_app_mut(RenderApp);
        render_app.insert_resource(Asks(asks));
    }

    /// Renders a frame. Returns true if the view's last frame is valid, and none if it keeps no history.
    fn frame(&mut self) -> Option<bool> {
        self.headless.frame();
        let world = self.headless.app.sub_app_mut(RenderApp).world_mut();
        let mut histories = world.query::<&ViewHistory>();
        let history = histories.iter(world).next()?;
        Some(history.last().is_some())
    }

    /// Asserts that `change` keeps the last frame valid.
    fn check_kept(&mut self, name: &str, change: impl FnOnce(&mut EntityWorldMut)) {
        assert_eq!(self.frame(), Some(true), "before {name}");
        let camera = self.camera;
        change(&mut self.headless.world().entity_mut(camera));
        assert_eq!(self.frame(), Some(true), "at {name}");
        assert_eq!(self.frame(), Some(true), "after {name}");
    }

    /// Asserts that `change` invalidates the last frame for one frame only.
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
    stage.check_kept("another viewport", |camera| {
        camera.get_mut::<Camera>().unwrap().viewport = Some(Viewport {
            physical_position: UVec2::new(8, 8),
            physical_size: UVec2::new(32, 32),
            ..default()
        });
    });
    // Upscalers override the resolution in the render world.
    assert_eq!(stage.frame(), Some(true));
    let world = stage.headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query_filtered::<Entity, With<ExtractedCamera>>();
    let view = views.single(world).expect("one camera");
    world
        .entity_mut(view)
        .insert(MainPassResolutionOverride(UVec2::splat(24)));
    assert_eq!(stage.frame(), Some(true), "at another resolution");
    assert_eq!(stage.frame(), Some(true), "after another resolution");
    let world = stage.headless.app.sub_app_mut(RenderApp).world_mut();
    world
        .entity_mut(view)
        .remove::<MainPassResolutionOverride>();
    assert_eq!(stage.frame(), Some(true), "at the former resolution");
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
    stage.check_kept("another target", |camera| {
        camera.get_mut::<Camera>().unwrap().viewport = None;
        camera.insert(RenderTarget::from(larger));
    });
    // After a pause.
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

    // Movement keeps it valid.
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
    assert_eq!(stage.frame(), None, "no effect reads it");
    stage.ask(true);
    assert_eq!(stage.frame(), Some(false), "somebody asks again");
    assert_eq!(stage.frame(), Some(true));
    // Multisampled depth cannot be kept.
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
    let texture = history.texture().clone();
    let last = history.last().copied().expect("the last frame is known");
    let units_per_metre = history.units_per_metre();

    let kept = read_light(&stage.headless, &texture);
    assert!(
        kept.size.cmpge(SIZE).all(),
        "as large as the viewport, or a little larger"
    );
    let texel = |x: u32, y: u32| kept.texels[(y * kept.size.x + x) as usize];
    let mut surfaces = 0;
    for (i, shown) in (0..).zip(picture.rgba.chunks(4)) {
        let (x, y) = (i % SIZE.x, i / SIZE.x);
        let [red, green, blue, distance] = texel(x, y);
        let [red, green, blue] = [red, green, blue].map(|part| part.clamp(0.0, 1.0));
        let srgb = Srgba::from(LinearRgba::rgb(red, green, blue));
        for (kept, shown) in [srgb.red, srgb.green, srgb.blue].into_iter().zip(shown) {
            let off = (kept * 255.0 - f32::from(*shown)).abs();
            assert!(off < 1.5, "pixel {x}, {y}: {kept}, shown as {shown:?}");
        }
        if distance == 65504.0 {
            continue;
        }
        surfaces += 1;
        let distance = distance / units_per_metre;
        assert!((0.1..100.0).contains(&distance), "metres away: {distance}");
        // On the floor, at a height of 0, or above it.
        let at = (Vec2::new(x as f32, y as f32) + 0.5) / SIZE.as_vec2() * 2.0 - 1.0;
        let ray = last.clip_from_view.inverse() * Vec4::new(at.x, -at.y, 1.0, 1.0);
        let place = (ray.xyz() / -ray.z * distance).extend(1.0);
        let height = (last.world_from_view * place).y;
        assert!((-0.02..2.0).contains(&height), "pixel {x}, {y}: {height}");
    }
    let pixels = SIZE.element_product();
    assert!(
        (pixels / 10..pixels * 9 / 10).contains(&surfaces),
        "{surfaces} of {pixels} pixels show a surface"
    );
}
