//! Textures of this crate that do not fit into memory: Bevy renders the camera, one message says what did not fit, and the camera is lean
//! again once it fits. In processes of their own, because the failure is logged as an error.

use std::sync::mpsc;

use bevy::{camera::Viewport, prelude::*, render::RenderApp};
use bevy_lean_deferred::{
    material_extension::SubsurfaceAlbedo,
    prelude::*,
    view::{DiffuseLight, OutOfMemory},
};
use kit::{
    headless::{Headless, Picture},
    lean::{active_lean_views, build, instant_exposure, settled},
    log_watch,
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::SceneBuilder,
    skipped::where_light_scatters,
};

const SIZE: UVec2 = UVec2::new(96, 64);

/// The picture once light that accumulates over frames has converged.
fn at_rest(headless: &mut Headless) -> Picture {
    headless.settle();
    headless.frames(32);
    settled(headless)
}

fn scene(s: &mut SceneBuilder) -> Entity {
    s.solids();
    s.sun(true);
    let mesh = s.add::<Mesh>(Sphere::new(0.4));
    let material = s.add::<ExtendedStandardMaterial>(ExtendedStandardMaterial {
        base: Color::WHITE.into(),
        extension: ShadingExtension::Subsurface {
            color: LinearRgba::WHITE.into(),
            mean_free_path: 0.05,
            albedo: SubsurfaceAlbedo::AfterScattering,
        },
    });
    s.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material),
        Transform::from_xyz(0.0, 0.4, 1.2),
    ));
    s.default_camera(())
}

/// Error scopes of different threads may end in any order: textures are created while other threads compile shaders.
#[test]
fn error_scopes_belong_to_threads() {
    let headless = Headless::new(SIZE);
    let device = headless.device().wgpu_device();
    let (has_begun, wait_for_begun) = mpsc::channel();
    let (has_ended, wait_for_end) = mpsc::channel::<()>();
    std::thread::scope(|threads| {
        let first = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        threads.spawn(move || {
            let second = device.push_error_scope(wgpu::ErrorFilter::Validation);
            has_begun.send(()).expect("it is waited for");
            wait_for_end.recv().expect_err("nothing is sent");
            drop(second);
        });
        wait_for_begun.recv().expect("the thread has begun");
        drop(first);
        drop(has_ended);
    });
}

fn make_scarce(headless: &mut Headless, labels: Option<&'static str>) {
    let render_world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut memory = render_world.resource_mut::<OutOfMemory>();
    memory.make_scarce(labels);
}

/// Renders `effects` with memory for their textures, without memory for those with these labels, and with memory again.
fn check(label: &'static str, effects: impl Bundle + Clone) {
    check_beside(label, (), effects);
}

/// As [`check`], on a camera with `others`, for which there is memory.
fn check_beside(label: &'static str, others: impl Bundle, effects: impl Bundle + Clone) {
    let mut camera = Entity::PLACEHOLDER;
    let mut headless = build(SIZE, |s| camera = scene(s));
    headless.world().entity_mut(camera).insert(others);
    let forward = settled(&mut headless);
    headless.world().entity_mut(camera).insert(effects.clone());
    let lean = at_rest(&mut headless);
    assert!(pixel_difference(&forward, &lean).largest > 0, "{label}");

    headless.world().entity_mut(camera).remove::<Effects>();
    headless.frames(3);
    make_scarce(&mut headless, Some(label));
    headless.world().entity_mut(camera).insert(effects);
    let film = headless.film(20, |_, _| {});
    let psnrs = film
        .iter()
        .map(|picture| pixel_difference(&forward, picture).psnr);
    let bad: Vec<f64> = psnrs.filter(|psnr| *psnr < 30.0).collect();
    println!(
        "{label}: {} of {} frames lack something, by dB: {bad:?}",
        bad.len(),
        film.len()
    );
    assert!(bad.is_empty(), "{label}: {} frames", bad.len());
    let difference = pixel_difference(&forward, &settled(&mut headless));
    assert_eq!(difference.largest, 0, "{label}: {difference}");

    let messages = log_watch::messages_with("does not fit into the GPU's memory");
    assert_eq!(messages.len(), 1, "{label}: {messages:#?}");
    assert!(messages[0].starts_with(label), "{messages:#?}");
    let status = headless.world().get::<LeanStatus>(camera);
    let status = status.expect("it has an effect").clone();
    let reason = LeanOffReason::OutOfMemory(messages[0].split(' ').next().unwrap().into());
    let [off, not_lean] = [reason, LeanOffReason::NotLean].map(EffectStatus::Off);
    for (component, status) in status.each() {
        let expected = match component {
            "LeanDeferred" | "LeanScreenSpaceAmbientOcclusion" => &off,
            "LeanAutoExposure" => &EffectStatus::On,
            _ => &not_lean,
        };
        assert_eq!(status, expected, "{label}: {component}");
    }

    make_scarce(&mut headless, None);
    for is_active in [false, true] {
        let mut entity = headless.world().entity_mut(camera);
        entity.get_mut::<Camera>().expect("it is one").is_active = is_active;
        headless.frame();
    }
    let difference = pixel_difference(&lean, &at_rest(&mut headless));
    // As in `lost_device.rs`: pixels that mirror themselves.
    assert!(difference.psnr > 60.0, "{label}: {difference}");
    assert!(log_watch::messages_with("Caught rendering error").is_empty());
    log_watch::assert_validation_layer_silent();
}

fn set_viewport(headless: &mut Headless, camera: Entity, width: u32) {
    let mut camera = headless.world().entity_mut(camera);
    let mut camera = camera.get_mut::<Camera>().expect("it is one");
    camera.viewport = Some(Viewport {
        physical_size: UVec2::new(width, 48),
        ..default()
    });
}

/// While a view is resized, textures whose headroom does not fit are created without it, and the camera stays lean.
#[test]
fn headroom_of_a_resized_view() {
    in_own_process(|| {
        let mut camera = Entity::PLACEHOLDER;
        let mut headless = build(SIZE, |s| camera = scene(s));
        headless.world().entity_mut(camera).insert((
            LeanDeferred::default(),
            LeanScreenSpaceGi::default(),
            LeanScreenSpaceReflections::default(),
        ));
        set_viewport(&mut headless, camera, 20);
        at_rest(&mut headless);
        headless.frames(60);
        let render_world = headless.app.sub_app_mut(RenderApp).world_mut();
        let mut memory = render_world.resource_mut::<OutOfMemory>();
        memory.make_headroom_scarce("lean_deferred/");
        for width in [30, 40, 50] {
            set_viewport(&mut headless, camera, width);
            headless.frame();
            assert_eq!(active_lean_views(&mut headless), 1, "{width} pixels");
        }
        let render_world = headless.app.sub_app_mut(RenderApp).world_mut();
        let mut lights = render_world.query::<&DiffuseLight>();
        let light = lights.single(render_world).expect("GI reads it");
        assert_eq!(light.texture.texture.width(), 50);
        let status = headless.world().get::<LeanStatus>(camera).cloned();
        for (component, status) in status.expect("it has effects").each() {
            assert!(status.is_on(), "{component}: {status}");
        }
        let messages = log_watch::messages_with("does not fit into the GPU's memory");
        assert!(messages.is_empty(), "{messages:#?}");
    });
}

type Effects = (
    LeanDeferred,
    LeanScreenSpaceAmbientOcclusion,
    LeanScreenSpaceGi,
    LeanScreenSpaceReflections,
    LeanSubsurfaceScattering,
);

#[test]
fn gbuffer() {
    in_own_process(|| check("lean_deferred/gbuffer", LeanDeferred::default()));
}

#[test]
#[ignore = "nightly: a further texture of the same effects"]
fn occlusion() {
    in_own_process(|| {
        check(
            "lean_deferred/effects/ambient_occlusion",
            LeanScreenSpaceAmbientOcclusion::default(),
        );
    });
}

#[test]
fn occlusion_of_a_lean_camera() {
    in_own_process(|| {
        check(
            "lean_deferred/effects/ambient_occlusion",
            (
                LeanDeferred::default(),
                LeanScreenSpaceAmbientOcclusion::default(),
            ),
        );
    });
}

/// Exposure needs no texture: it stays on a camera without memory for its other effects, and meters Bevy's picture.
#[test]
fn exposure_of_a_lean_camera() {
    in_own_process(|| {
        let effects = (LeanDeferred::default(), LeanScreenSpaceGi::default());
        check_beside("lean_deferred/", instant_exposure(), effects);
    });
}

#[test]
#[ignore = "nightly: a further texture of the same effects"]
fn diffuse_light() {
    in_own_process(|| {
        check(
            "lean_deferred/lighting/diffuse",
            (LeanDeferred::default(), LeanScreenSpaceGi::default()),
        );
    });
}

#[test]
fn diffuse_gi() {
    in_own_process(|| {
        check(
            "lean_deferred/effects/diffuse_gi",
            (LeanDeferred::default(), LeanScreenSpaceGi::default()),
        );
    });
}

#[test]
fn reflections() {
    in_own_process(|| {
        check(
            "lean_deferred/effects/reflections",
            (
                LeanDeferred::default(),
                LeanScreenSpaceReflections::default(),
            ),
        );
    });
}

#[test]
#[ignore = "nightly: a further texture of the same effects"]
fn history() {
    in_own_process(|| {
        check(
            "lean_deferred/effects/history",
            (
                LeanDeferred::default(),
                LeanScreenSpaceReflections::default(),
            ),
        );
    });
}

#[test]
fn scattering() {
    where_light_scatters(|| {
        check(
            "lean_deferred/lighting/subsurface_light",
            LeanSubsurfaceScattering::default(),
        )
    });
}

#[test]
#[ignore = "nightly: a further texture of the same effects"]
fn scattered_light() {
    where_light_scatters(|| {
        check(
            "lean_deferred/effects/subsurface/scattered",
            LeanSubsurfaceScattering::default(),
        )
    });
}
