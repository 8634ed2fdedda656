//! Passes that come first in the main pass.

use core::iter;

use bevy::{
    core_pipeline::schedule::Core3dSystems,
    ecs::schedule::{
        FlattenedDependencies, InternedSystemSet, NodeId, ScheduleBuildError, ScheduleBuildPass,
        ScheduleGraph, SystemKey, SystemSetKey, graph::DiGraph,
    },
    platform::hash::FixedHasher,
    prelude::*,
};
use indexmap::IndexSet;

use super::{
    opaque_picture::{is_before, systems_in},
    schedule::LightingPasses,
};

/// Has all systems of a set run before all others within a set but those that are asked to run before them. The others may be of other
/// crates, which know nothing of these.
#[derive(Debug)]
pub(super) struct FirstWithin {
    set: InternedSystemSet,
    first: InternedSystemSet,
}

impl FirstWithin {
    /// [`LightingPasses`] in Bevy's main pass. What others draw there, colour and depth, lies among the meshes that are lit, as among those
    /// that Bevy draws.
    pub(super) fn main_pass() -> Self {
        Self {
            set: Core3dSystems::MainPass.intern(),
            first: LightingPasses.intern(),
        }
    }
}

/// Those that were put into `set`, or into a set within it.
fn systems_within(graph: &ScheduleGraph, set: InternedSystemSet) -> Vec<SystemKey> {
    let mut sets: Vec<SystemSetKey> = graph.system_sets.get_key(set).into_iter().collect();
    let mut systems = Vec::new();
    let mut next = 0;
    while let Some(&set) = sets.get(next) {
        next += 1;
        for child in graph.hierarchy().graph().neighbors(NodeId::Set(set)) {
            match child {
                NodeId::System(system) if !systems.contains(&system) => systems.push(system),
                NodeId::Set(inner) if !sets.contains(&inner) => sets.push(inner),
                _ => {}
            }
        }
    }
    systems
}

impl ScheduleBuildPass for FirstWithin {
    type EdgeOptions = ();

    fn add_dependency(&mut self, _: NodeId, _: NodeId, _: Option<&()>) {}

    fn collapse_set(
        &mut self,
        _: SystemSetKey,
        _: &IndexSet<SystemKey, FixedHasher>,
        _: &DiGraph<NodeId>,
    ) -> impl Iterator<Item = (NodeId, NodeId)> {
        iter::empty()
    }

    fn build(
        &mut self,
        _: &mut World,
        graph: &mut ScheduleGraph,
        mut dependencies: FlattenedDependencies<'_>,
    ) -> Result<(), ScheduleBuildError> {
        let first = systems_in(graph, self.first);
        for other in systems_within(graph, self.set) {
            if first.contains(&other) {
                continue;
            }
            for &one in &first {
                let graph = dependencies.graph();
                if !is_before(graph, other, one) && !is_before(graph, one, other) {
                    dependencies.add_edge(one, other);
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use bevy::{core_pipeline::schedule::Core3dSystems, ecs::schedule::ScheduleLabel, prelude::*};

    use super::{FirstWithin, LightingPasses};

    #[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
    struct Frame;

    #[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
    struct Inner;

    #[derive(Resource, Default)]
    struct Ran(Vec<&'static str>);

    fn asked(mut ran: ResMut<Ran>) {
        ran.0.push("asked");
    }

    fn lighting(mut ran: ResMut<Ran>) {
        ran.0.push("lighting");
    }

    fn other<const N: u32>(mut ran: ResMut<Ran>) {
        ran.0.push("other");
    }

    /// Others were added before and after, into the set or into one within it, and one is asked to run before.
    #[test]
    fn first_systems_run_before_all_others_of_the_set() {
        let mut schedule = Schedule::new(Frame);
        schedule
            .add_build_pass(FirstWithin::main_pass())
            .configure_sets(Inner.in_set(Core3dSystems::MainPass))
            .add_systems((
                other::<0>.in_set(Core3dSystems::MainPass),
                other::<1>.in_set(Inner),
            ))
            .add_systems(
                lighting
                    .in_set(LightingPasses)
                    .in_set(Core3dSystems::MainPass),
            )
            .add_systems((
                other::<2>.in_set(Core3dSystems::MainPass),
                other::<3>.in_set(Inner),
                asked.in_set(Core3dSystems::MainPass).before(LightingPasses),
            ));
        let mut world = World::new();
        world.init_resource::<Ran>();
        schedule.run(&mut world);
        let ran = &world.resource::<Ran>().0;
        assert_eq!(*ran, [&["asked", "lighting"][..], &["other"; 4]].concat());
    }
}
