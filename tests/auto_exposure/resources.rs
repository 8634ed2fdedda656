//! GPU resources of a camera with auto exposure.

use bevy::{
    anti_alias::fxaa::Fxaa,
    prelude::*,
    render::{RenderApp, render_resource::BindGroupId},
};
use bevy_lean_deferred::effects::auto_exposure::{ExposureBindings, LeanAutoExposure};

use kit::{gpu_usage::GpuUsage, headless::Headless};

fn headless(effects: impl Bundle) -> (Headless, Entity) {
    let mut headless = Headless::new(UVec2::new(300, 200));
    let target = headless.render_target();
    let camera = (Camera3d::default(), Msaa::Off, target, effects);
    let camera = headless.world().spawn(camera).id();
    headless.settle();
    (headless, camera)
}

/// Bind groups of all views.
fn bind_groups(headless: &mut Headless) -> Vec<BindGroupId> {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    world
        .query::<&ExposureBindings>()
        .iter(world)
        .flat_map(ExposureBindings::lasting_bind_groups)
        .map(|group| group.id())
        .collect()
}

/// While nothing changes, no bind group and no resource in it is recreated, though FXAA swaps the main textures.
#[test]
fn nothing_is_made_anew() {
    let effects = (
        bevy::camera::Hdr,
        Fxaa::default(),
        LeanAutoExposure::default(),
    );
    let (mut headless, _) = headless(effects);
    let groups = bind_groups(&mut headless);
    assert_eq!(groups.len(), 3, "one for each main texture, one to adapt");
    for _ in 0..16 {
        headless.frames(1);
        let mut after = bind_groups(&mut headless);
        // They swap like the main textures.
        if after != groups {
            after.swap(0, 1);
        }
        assert_eq!(after, groups);
    }
}

/// Removing the component releases all that it added.
#[test]
fn what_is_held_is_given_back() {
    let (mut headless, camera) = headless(bevy::camera::Hdr);
    let mut held = |auto_exposure| {
        let mut entity = headless.world().entity_mut(camera);
        if auto_exposure {
            entity.insert(LeanAutoExposure::default());
        } else {
            entity.remove::<LeanAutoExposure>();
        }
        headless.settle();
        headless.frames(8);
        let GpuUsage {
            textures,
            buffers,
            bind_groups,
            ..
        } = GpuUsage::now(&headless);
        let held = [textures, buffers, bind_groups];
        println!("auto exposure: {auto_exposure}, textures, buffers, bind groups: {held:?}");
        held
    };
    held(true);
    let without = held(false);
    let with = held(true);
    assert_eq!(with[0], without[0], "it needs no texture");
    assert!(with[1] > without[1]);
    assert_eq!(held(false), without);
    assert_eq!(held(true), with);
}
