//! Cameras that cannot be rendered lean: one warning that names the reason, and Bevy's own picture.

mod common;

use bevy::{
    camera::Hdr,
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    prelude::*,
    render::RenderApp,
};
use bevy_lean_deferred::{camera::LeanDeferredSupport, prelude::*};
use common::{
    headless::{Headless, Picture, log_watch},
    lean::{active_lean_views, build},
};

const SIZE: UVec2 = UVec2::new(160, 120);

/// The solids, and the camera that sees them.
fn scene() -> (Headless, Entity) {
    let mut camera = Entity::PLACEHOLDER;
    let headless = build(SIZE, |s| {
        s.solids();
        s.sun(true);
        camera = s.default_camera(());
    });
    (headless, camera)
}

/// Renders the solids with a camera made by `spoil` from the usual one, without and with `LeanDeferred`.
fn pictures(spoil: fn(&mut EntityWorldMut)) -> (Picture, Picture) {
    let (mut headless, camera) = scene();
    spoil(&mut headless.world().entity_mut(camera));
    headless.settle();
    let without = headless.capture();

    headless
        .world()
        .entity_mut(camera)
        .insert(LeanDeferred::default());
    // Adding the component makes the camera fit; what comes after does not.
    spoil(&mut headless.world().entity_mut(camera));
    headless.settle();
    (without, headless.capture())
}

fn assert_falls_back(spoil: fn(&mut EntityWorldMut), reason: &str) {
    let (without, with) = pictures(spoil);
    assert!(without.rgba == with.rgba, "the picture is not Bevy's");
    let warnings = log_watch::messages_with(reason);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
}

#[test]
fn msaa() {
    assert_falls_back(
        |camera| {
            camera.insert(Msaa::Sample4);
        },
        "its Msaa is not Off",
    );
}

#[test]
fn no_hdr() {
    assert_falls_back(
        |camera| {
            camera.remove::<Hdr>();
        },
        "it has no Hdr component",
    );
}

#[test]
fn deferred_prepass() {
    assert_falls_back(
        |camera| {
            camera.insert((DepthPrepass, DeferredPrepass));
        },
        "it has DeferredPrepass",
    );
}

/// A device that lacks something, as `finish` would have found it.
#[test]
fn missing_support() {
    let (mut headless, camera) = scene();
    headless
        .app
        .sub_app_mut(RenderApp)
        .insert_resource(LeanDeferredSupport::Missing("a storage texture".into()));
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
