//! The order of passes in Bevy's frame.

use bevy::{
    core_pipeline::{core_3d::main_opaque_pass_3d, schedule::Core3d},
    ecs::schedule::{NodeId, SystemKey},
    prelude::*,
    render::RenderApp,
};
use bevy_lean_deferred::view::OpaquePicturePasses;

use super::{SIZE, solids};
use kit::headless::Headless;

/// Systems of a set.
fn members(schedule: &Schedule, set: impl SystemSet) -> Vec<SystemKey> {
    let systems = schedule.graph().systems_in_set(set.intern());
    systems.expect("it was built").iter().copied().collect()
}

/// Passes of the opaque picture precede Bevy's atmosphere, which draws the air in front of opaque meshes by a system without a public name.
/// Occlusion darkens only the surfaces behind the air.
#[test]
fn passes_of_the_opaque_picture_come_before_the_air() {
    let (mut headless, _) = solids(Headless::new(SIZE));
    headless.frames(3);
    let schedules = headless
        .app
        .sub_app(RenderApp)
        .world()
        .resource::<Schedules>();
    let schedule = schedules.get(Core3d).expect("it renders");
    let order: Vec<SystemKey> = schedule
        .systems()
        .expect("it ran")
        .map(|(key, _)| key)
        .collect();
    let place = |key| {
        order
            .iter()
            .position(|other| *other == key)
            .expect("it runs")
    };

    let ours = members(schedule, OpaquePicturePasses);
    assert_eq!(ours.len(), 3, "of occlusion, of GI, of the history");
    let graph = schedule.graph();
    let opaque = main_opaque_pass_3d.into_system_set();
    let opaque = graph.system_sets.get_key(opaque.intern()).expect("it runs");
    // Systems ordered after the pass by its name, not by a set.
    let following = graph.dependency().graph().neighbors(NodeId::Set(opaque));
    let others: Vec<SystemKey> = following
        .filter_map(|node| node.as_system())
        .filter(|key| !ours.contains(key))
        .collect();
    assert!(!others.is_empty(), "Bevy's atmosphere is one");
    for other in others {
        assert!(ours.iter().all(|one| place(*one) < place(other)));
    }
}
