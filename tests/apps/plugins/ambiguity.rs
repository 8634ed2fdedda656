//! Systems that share data are ordered, or declare that their order does not matter.

use std::fmt::Write;

use bevy::{prelude::*, render::RenderApp};

use super::{SIZE, solids};
use kit::headless::Headless;

/// Bevy's own frame has none.
fn ambiguities(world: &World, found: &mut String) {
    for (label, schedule) in world.resource::<Schedules>().iter() {
        let pairs = schedule.graph().conflicting_systems();
        // Bevy's feature `debug` names them.
        for (a, b, data) in pairs.iter() {
            let names = [a, b].map(|key| {
                let mut systems = schedule.systems().expect("it ran");
                let system = systems.find(|(other, _)| other == key);
                system.map(|(_, system)| system.name())
            });
            let data: Vec<_> = (data.iter().map(|id| world.components().get_name(*id))).collect();
            writeln!(found, "{label:?}: {names:?}: {data:?}").expect("it is a string");
        }
    }
}

#[test]
fn no_order_is_left_to_chance() {
    let (mut headless, _) = solids(Headless::new(SIZE));
    headless.frames(3);
    let mut found = String::new();
    ambiguities(headless.world(), &mut found);
    let render_world = headless.app.sub_app(RenderApp).world();
    ambiguities(render_world, &mut found);
    assert!(found.is_empty(), "\n{found}");
}
