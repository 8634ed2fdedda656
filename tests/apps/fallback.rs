//! Cameras that cannot be rendered lean: one warning names the reason, and the picture is Bevy's. Tests that count warnings run in
//! processes of their own, one for the cases that share pipelines.

use bevy::{
    camera::{Hdr, Viewport},
    core_pipeline::{
        core_3d::main_opaque_pass_3d,
        prepass::{DeferredPrepass, DepthPrepass},
        schedule::Core2d,
        tonemapping::tonemapping,
        upscaling::upscaling,
    },
    ecs::schedule::ScheduleLabel,
    pbr::{
        clear_indirect_parameters_metadata, early_gpu_preprocess, main_build_indirect_parameters,
        unpack_bins,
    },
    prelude::*,
    render::{RenderApp, camera::CameraRenderGraph},
};
use bevy_lean_deferred::{lighting::ViewLighting, prelude::*};
use kit::{
    headless::{Headless, Picture, target_image},
    lean::{active_lean_views, build, show},
    log_watch,
    metrics::pixel_difference,
    own_process::in_own_process,
};

const SIZE: UVec2 = UVec2::new(160, 120);

/// The solids, and the camera that sees them.
fn scene() -> (Headless, Entity) {
    let mut headless = Headless::new(SIZE);
    let camera = show_scene(&mut headless);
    (headless, camera)
}

/// As [`scene`], in an app that may have shown it before, to another camera.
fn show_scene(headless: &mut Headless) -> Entity {
    let mut camera = Entity::PLACEHOLDER;
    show(headless, |s| {
        s.solids();
        s.sun(true);
        // Visible to 2D cameras only.
        s.spawn(Sprite::from_color(
            Color::srgb(0.7, 0.3, 0.2),
            Vec2::splat(40.0),
        ));
        camera = s.default_camera(());
    });
    camera
}

/// An app that knows [`own_frame`].
fn app() -> Headless {
    let mut headless = Headless::new(SIZE);
    let render_app = headless.app.sub_app_mut(RenderApp);
    render_app.add_schedule(own_frame());
    headless
}

/// Pictures of the solids without and with an effect, by the usual camera changed by `spoil`.
fn pictures<E: Component + Default>(
    headless: &mut Headless,
    spoil: fn(&mut EntityWorldMut),
) -> (Picture, Picture) {
    // Nothing of an earlier case is seen in it.
    let target = target_image(SIZE);
    headless.target = headless.world().resource_mut::<Assets<Image>>().add(target);
    let camera = show_scene(headless);
    spoil(&mut headless.world().entity_mut(camera));
    headless.settle();
    let without = headless.capture();

    headless.world().entity_mut(camera).insert(E::default());
    // Adding the component makes the camera fit; `spoil` undoes that.
    spoil(&mut headless.world().entity_mut(camera));
    headless.settle();
    (without, headless.capture())
}

fn assert_effect_is_off<E: Component + Default>(
    headless: &mut Headless,
    spoil: fn(&mut EntityWorldMut),
    reason: &str,
) {
    let effect = core::any::type_name::<E>();
    let told = log_watch::messages_with(reason).len();
    let (without, with) = pictures::<E>(headless, spoil);
    let first = &without.rgba[..4];
    let is_empty = without.rgba.chunks(4).all(|pixel| pixel == first);
    assert!(!is_empty, "{effect}, {reason}: nothing is seen");
    let is_bevys = without.rgba == with.rgba;
    assert!(is_bevys, "{effect}, {reason}: the picture is not Bevy's");
    let warnings = log_watch::messages_with(reason).split_off(told);
    assert_eq!(warnings.len(), 1, "{effect}, {reason}: {warnings:?}");
}

fn assert_falls_back(headless: &mut Headless, spoil: fn(&mut EntityWorldMut), reason: &str) {
    assert_effect_is_off::<LeanDeferred>(headless, spoil, reason);
}

/// Label of an app's own render schedule.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct OwnFrame;

/// Bevy's forward pass and the systems that it needs.
fn own_frame() -> Schedule {
    let mut schedule = Schedule::new(OwnFrame);
    schedule.add_systems(
        (
            clear_indirect_parameters_metadata,
            unpack_bins,
            early_gpu_preprocess,
            main_build_indirect_parameters,
            main_opaque_pass_3d,
            tonemapping,
            upscaling,
        )
            .chain(),
    );
    schedule
}

#[test]
fn settings() {
    in_own_process(|| {
        let mut headless = app();
        assert_falls_back(
            &mut headless,
            |camera| {
                camera.insert(Msaa::Sample4);
            },
            "its `Msaa` is not `Off`",
        );
        assert_falls_back(
            &mut headless,
            |camera| {
                camera.remove::<Hdr>();
            },
            "it has no `Hdr`",
        );
        assert_falls_back(
            &mut headless,
            |camera| {
                camera.insert((DepthPrepass, DeferredPrepass));
            },
            "it has `DeferredPrepass`",
        );
    });
}

fn squeeze_depth(camera: &mut EntityWorldMut) {
    if let Some(mut camera) = camera.get_mut::<Camera>() {
        camera.viewport = Some(Viewport {
            physical_size: SIZE,
            depth: 0.0..0.5,
            ..default()
        });
    }
}

const SQUEEZED: &str = "its `Viewport::depth` is not 0 to 1";

#[test]
fn depth_of_the_viewport() {
    in_own_process(|| {
        let mut headless = app();
        assert_falls_back(&mut headless, squeeze_depth, SQUEEZED);
        assert_effect_is_off::<LeanScreenSpaceAmbientOcclusion>(
            &mut headless,
            squeeze_depth,
            SQUEEZED,
        );
    });
}

fn leave_core_3d(camera: &mut EntityWorldMut) {
    camera.insert(CameraRenderGraph::new(OwnFrame));
}

const OWN_SCHEDULE: &str = "its `CameraRenderGraph` is not `Core3d`";

#[test]
fn own_schedule() {
    in_own_process(|| {
        let mut headless = app();
        assert_falls_back(&mut headless, leave_core_3d, OWN_SCHEDULE);
        assert_effect_is_off::<LeanScreenSpaceAmbientOcclusion>(
            &mut headless,
            leave_core_3d,
            OWN_SCHEDULE,
        );
        assert_effect_is_off::<LeanAutoExposure>(
            &mut headless,
            leave_core_3d,
            "its `CameraRenderGraph` is neither `Core3d` nor `Core2d`",
        );
    });
}

const NOT_3D: &str = "it has no `Camera3d`";

/// Turns a camera into a 2D camera.
fn make_2d(camera: &mut EntityWorldMut) {
    camera.remove::<Camera3d>().insert((
        Camera2d,
        CameraRenderGraph::new(Core2d),
        Projection::from(OrthographicProjection::default_2d()),
        Transform::default(),
    ));
}

#[test]
fn of_sprites() {
    in_own_process(|| {
        let mut headless = app();
        assert_falls_back(&mut headless, make_2d, NOT_3D);
        assert_effect_is_off::<LeanScreenSpaceAmbientOcclusion>(&mut headless, make_2d, NOT_3D);
        assert_effect_is_off::<LeanScreenSpaceReflections>(&mut headless, make_2d, NOT_3D);
        assert_effect_is_off::<LeanScreenSpaceGi>(&mut headless, make_2d, NOT_3D);
    });
}

/// A lean camera that loses `Camera3d` stops being lean, and resumes once it has it again.
#[test]
fn what_loses_its_camera_3d() {
    in_own_process(|| {
        let (mut headless, camera) = scene();
        headless.world().entity_mut(camera).insert((
            LeanDeferred::default(),
            LeanScreenSpaceAmbientOcclusion::default(),
            LeanScreenSpaceReflections::default(),
            LeanScreenSpaceGi::default(),
        ));
        headless.settle();
        let before = headless.capture();
        for _ in 0..2 {
            assert_eq!(active_lean_views(&mut headless), 1);
            headless.world().entity_mut(camera).remove::<Camera3d>();
            headless.frames(3);
            assert_eq!(active_lean_views(&mut headless), 0);
            let render_world = headless.app.sub_app_mut(RenderApp).world_mut();
            let mut kept = render_world.query_filtered::<Entity, With<ViewLighting>>();
            assert_eq!(kept.iter(render_world).count(), 0);

            headless
                .world()
                .entity_mut(camera)
                .insert(Camera3d::default());
            headless.settle();
        }
        let difference = pixel_difference(&before, &headless.capture());
        println!("{difference}");
        assert!(difference.psnr > 45.0);
        // Each loss is reported.
        let warnings = log_watch::messages_with(NOT_3D);
        assert_eq!(warnings.len(), 4, "{warnings:?}");
    });
}

/// A device that lacks a capability, as `RenderStartup` would have detected it.
#[test]
fn missing_support() {
    let (mut headless, camera) = scene();
    headless.frames(1);
    let render_world = headless.app.sub_app_mut(RenderApp).world_mut();
    render_world.resource_mut::<LeanSupport>().deferred = Err("a storage texture".into());
    headless.settle();
    let without = headless.capture();
    headless
        .world()
        .entity_mut(camera)
        .insert(LeanDeferred::default());
    headless.settle();
    assert!(without.rgba == headless.capture().rgba);
}

#[test]
fn spawning_with_the_default_msaa_works() {
    let mut headless = build(SIZE, |s| {
        s.solids();
        s.sun(true);
        let target = s.headless.render_target();
        s.spawn((
            Camera3d::default(),
            LeanDeferred::default(),
            target,
            Transform::from_xyz(-1.5, 2.8, 5.2).looking_at(Vec3::ZERO, Vec3::Y),
        ));
    });
    headless.settle();
    assert_eq!(active_lean_views(&mut headless), 1);
    log_watch::assert_validation_layer_silent();
}
