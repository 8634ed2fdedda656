//! Cameras release an effect's GPU resources when its component is removed, the camera is deactivated, or the camera no longer supports the
//! effect.

use bevy::{
    camera::Hdr,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{BindGroup, BindGroupId},
    },
};
use bevy_lean_deferred::{
    LeanAutoExposure, LeanDeferred, LeanScreenSpaceAmbientOcclusion, LeanScreenSpaceGi,
    LeanScreenSpaceReflections, LeanSubsurfaceScattering,
    ambient_occlusion::OcclusionBindings,
    screen_space::{
        ViewHistory, diffuse_gi::GiBindings, reflections::ReflectionBindings,
        subsurface::ViewSubsurface,
    },
};
use kit::{
    analytic_slabs::{patterned, slab, step},
    gpu_usage::GpuUsage,
    headless::Headless,
    lean::{active_lean_views, build, set_lean},
    skipped::has_room_for_scattering,
};

/// Resources once nothing changes any more. Excludes buffers and their bytes, which Bevy grows at will, and pipelines, which it keeps.
fn held(headless: &mut Headless) -> GpuUsage {
    GpuUsage {
        buffers: 0,
        bytes: 0,
        pipelines: 0,
        ..GpuUsage::once_settled(headless)
    }
}

#[test]
fn what_is_held_is_given_back() {
    let mut camera = Entity::PLACEHOLDER;
    let mut headless = build(UVec2::new(160, 120), |s| {
        s.solids();
        s.sun(true);
        camera = s.default_camera(());
    });
    let mut held_by = |lean, is_active| {
        set_lean(&mut headless, lean);
        let mut camera = headless.world().entity_mut(camera);
        camera.get_mut::<Camera>().expect("it is one").is_active = is_active;
        let held = held(&mut headless);
        println!("lean: {lean}, active: {is_active}, {held:?}");
        held
    };

    let forward = held_by(false, true);
    let forward_off = held_by(false, false);
    let lean = held_by(true, true);
    let forward_again = held_by(false, true);
    let lean_again = held_by(true, true);
    let lean_off = held_by(true, false);
    held_by(true, true);
    assert_eq!(active_lean_views(&mut headless), 1, "it is off for ever");

    let textures = |held: GpuUsage| [held.textures, held.texture_views];
    assert_eq!(
        textures(lean),
        textures(forward).map(|count| count + 2),
        "the G-buffer has two"
    );
    assert_eq!(textures(forward_again), textures(forward));
    assert_eq!(textures(lean_off), textures(forward_off));
    // Bevy keeps a few bind groups per kind of render phase ever used. They do not accumulate.
    assert_eq!(lean_again, lean);
}

/// States of a camera.
#[derive(Clone, Copy, Debug)]
enum State {
    Usual,
    SwitchedOff,
    Multisampled,
    NotHdr,
}

fn set_state(headless: &mut Headless, camera: Entity, state: State) {
    let mut camera = headless.world().entity_mut(camera);
    camera.get_mut::<Camera>().expect("it is one").is_active = !matches!(state, State::SwitchedOff);
    camera.insert(match state {
        State::Multisampled => Msaa::Sample4,
        _ => Msaa::Off,
    });
    if matches!(state, State::NotHdr) {
        camera.remove::<Hdr>();
    } else {
        camera.insert(Hdr);
    }
}

/// In each of `states` the camera holds as much with the component as without it, even if it held more before.
fn check_states<C: Component + Default>(states: &[State], compares_bind_groups: bool) {
    check_states_beside::<C>((), states, compares_bind_groups);
}

/// As [`check_states`], for a camera with `others`.
fn check_states_beside<C: Component + Default>(
    others: impl Bundle,
    states: &[State],
    compares_bind_groups: bool,
) {
    let name = core::any::type_name::<C>();
    let mut camera = Entity::PLACEHOLDER;
    let mut headless = build(UVec2::new(160, 120), |s| {
        s.solids();
        camera = s.default_camera(others);
    });
    let mut held_in = |with: bool, state: State| {
        if with {
            headless.world().entity_mut(camera).insert(C::default());
        } else {
            headless.world().entity_mut(camera).remove::<C>();
        }
        set_state(&mut headless, camera, state);
        let mut held = held(&mut headless);
        println!("{name}: {with}, {state:?}, {held:?}");
        if !compares_bind_groups {
            held.bind_groups = 0;
        }
        held
    };
    // Bevy keeps some resources that were ever used.
    for state in [&[State::Usual], states].concat() {
        held_in(true, state);
    }
    for state in states {
        // Deactivated views keep what Bevy made for them.
        held_in(false, State::Usual);
        let without = held_in(false, *state);
        let usual = held_in(true, State::Usual);
        assert_eq!(held_in(true, *state), without, "{name}, {state:?}");
        assert_eq!(held_in(true, State::Usual), usual, "{name}, {state:?}");
    }
}

#[test]
fn lean_cameras_that_cannot_be_lean_hold_nothing() {
    check_states::<LeanDeferred>(
        &[State::SwitchedOff, State::Multisampled, State::NotHdr],
        // Bevy's own bind groups depend on earlier use.
        false,
    );
}

#[test]
fn cameras_without_occlusion_hold_nothing_of_it() {
    check_states::<LeanScreenSpaceAmbientOcclusion>(
        &[State::SwitchedOff, State::Multisampled],
        true,
    );
}

#[test]
fn cameras_without_diffuse_gi_hold_nothing_of_it() {
    let lean = LeanDeferred::default();
    check_states_beside::<LeanScreenSpaceGi>(lean, &[State::SwitchedOff, State::NotHdr], false);
}

#[test]
fn cameras_without_reflections_hold_nothing_of_them() {
    let lean = LeanDeferred::default();
    let states = [State::SwitchedOff, State::NotHdr];
    check_states_beside::<LeanScreenSpaceReflections>(lean, &states, false);
}

#[test]
fn cameras_that_are_not_metered_hold_nothing_for_it() {
    check_states::<LeanAutoExposure>(&[State::SwitchedOff, State::NotHdr], true);
}

#[test]
fn removed_occlusion_is_given_back() {
    let mut camera = Entity::PLACEHOLDER;
    let mut headless = build(UVec2::new(160, 120), |s| {
        s.solids();
        camera = s.default_camera(());
    });
    for lean in [false, true] {
        set_lean(&mut headless, lean);
        let [with, without, again] = [true, false, true].map(|with| {
            let mut camera = headless.world().entity_mut(camera);
            if with {
                camera.insert(LeanScreenSpaceAmbientOcclusion::default());
            } else {
                camera.remove::<LeanScreenSpaceAmbientOcclusion>();
            }
            let held = held(&mut headless);
            println!("lean: {lean}, occlusion: {with}, {held:?}");
            held
        });
        assert_eq!(with, again);
        assert_eq!(with.textures, without.textures + 1);
        assert_eq!(with.texture_views, without.texture_views + 1);
        let groups = if lean { 1 } else { 2 };
        assert_eq!(with.bind_groups, without.bind_groups + groups);
    }
}

/// Bind groups that all views hold in their `C`.
fn groups_of<C: Component>(
    headless: &mut Headless,
    groups: impl Fn(&C) -> Vec<&BindGroup>,
) -> Vec<BindGroupId> {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<&C>();
    let groups = views.iter(world).flat_map(groups);
    groups.map(BindGroup::id).collect()
}

/// While nothing changes, no bind group of an effect is recreated.
#[test]
fn nothing_of_effects_is_made_anew() {
    let mut camera = Entity::PLACEHOLDER;
    let mut headless = build(UVec2::new(160, 120), |s| {
        s.solids();
        patterned(s, slab(LinearRgba::WHITE, 0.1), default(), step);
        camera = s.default_camera((
            LeanScreenSpaceAmbientOcclusion::default(),
            LeanScreenSpaceGi::default(),
            LeanScreenSpaceReflections::default(),
            LeanSubsurfaceScattering::default(),
        ));
    });
    let has_room = has_room_for_scattering(&headless.device().limits());
    for lean in [false, true] {
        set_lean(&mut headless, lean);
        let _ = held(&mut headless);
        let mut groups = || {
            headless.frames(1);
            [
                groups_of::<OcclusionBindings>(&mut headless, |held| {
                    held.lasting_bind_groups().collect()
                }),
                groups_of::<GiBindings>(&mut headless, |held| held.lasting_bind_groups().collect()),
                groups_of::<ReflectionBindings>(&mut headless, |held| {
                    held.lasting_bind_groups().collect()
                }),
                groups_of::<ViewHistory>(&mut headless, |held| {
                    held.lasting_bind_groups().collect()
                }),
                groups_of::<ViewSubsurface>(&mut headless, |held| {
                    held.lasting_bind_groups().collect()
                }),
            ]
        };
        let first = groups();
        // GI has two of each, as this frame's levels are the next one's history, and makes occlusion unnecessary. Bevy has two main
        // textures. Scattering has one per dispatch, and two for the last.
        let scattering = if has_room { 7 } else { 0 };
        let expected = if lean {
            [0, 6, 4, 3, scattering]
        } else {
            [2, 0, 0, 0, 0]
        };
        assert_eq!(first.each_ref().map(Vec::len), expected);
        for _ in 0..8 {
            assert_eq!(groups(), first);
        }
    }
}
