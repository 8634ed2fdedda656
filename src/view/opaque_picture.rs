//! Passes that come first after the opaque one.

use core::iter;

use bevy::{
    core_pipeline::core_3d::main_opaque_pass_3d,
    ecs::schedule::{
        FlattenedDependencies, InternedSystemSet, NodeId, ScheduleBuildError, ScheduleBuildPass,
        ScheduleGraph, SystemKey, SystemSetKey, graph::DiGraph,
    },
    platform::hash::FixedHasher,
    prelude::*,
};
use indexmap::IndexSet;

use super::schedule::OpaquePicturePasses;

/// Has all systems of a set run before all others that follow a system. Those cannot be named where they are private, as Bevy's
/// `render_sky` is, which draws the air in front of meshes.
#[derive(Debug)]
pub(super) struct FirstAfter {
    system: InternedSystemSet,
    first: InternedSystemSet,
}

impl FirstAfter {
    /// [`OpaquePicturePasses`] after Bevy's opaque pass.
    pub(super) fn opaque_pass() -> Self {
        Self {
            system: main_opaque_pass_3d.into_system_set().intern(),
            first: OpaquePicturePasses.intern(),
        }
    }
}

/// Those that were put into `set` by name.
pub(super) fn systems_in(graph: &ScheduleGraph, set: InternedSystemSet) -> Vec<SystemKey> {
    let Some(set) = graph.system_sets.get_key(set) else {
        return Vec::new();
    };
    let children = graph.hierarchy().graph().neighbors(NodeId::Set(set));
    children.filter_map(|child| child.as_system()).collect()
}

pub(super) fn is_before(graph: &DiGraph<SystemKey>, one: SystemKey, other: SystemKey) -> bool {
    let mut seen = vec![one];
    let mut next = 0;
    while let Some(&system) = seen.get(next) {
        if system == other {
            return true;
        }
        next += 1;
        for follower in graph.neighbors(system) {
            if !seen.contains(&follower) {
                seen.push(follower);
            }
        }
    }
    false
}

impl ScheduleBuildPass for FirstAfter {
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
        for system in systems_in(graph, self.system) {
            let followers: Vec<SystemKey> = dependencies.graph().neighbors(system).collect();
            for other in followers {
                for &one in &first {
                    if !first.contains(&other) && !is_before(dependencies.graph(), other, one) {
                        dependencies.add_edge(one, other);
                    }
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use bevy::{ecs::schedule::ScheduleLabel, prelude::*};

    use super::{FirstAfter, OpaquePicturePasses};

    #[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
    struct Frame;

    #[derive(Resource, Default)]
    struct Ran(Vec<&'static str>);

    fn asked(mut ran: ResMut<Ran>) {
        ran.0.push("asked");
    }

    fn opaque(mut ran: ResMut<Ran>) {
        ran.0.push("opaque");
    }

    fn before(mut ran: ResMut<Ran>) {
        ran.0.push("before");
    }

    fn first(mut ran: ResMut<Ran>) {
        ran.0.push("first");
    }

    fn follower<const N: u32>(mut ran: ResMut<Ran>) {
        ran.0.push("follower");
    }

    /// What ran, in order.
    fn run(mut schedule: Schedule) -> Vec<&'static str> {
        let mut world = World::new();
        world.init_resource::<Ran>();
        schedule.run(&mut world);
        core::mem::take(&mut world.resource_mut::<Ran>().0)
    }

    /// Systems that follow were added before and after, and one of them is asked to run before the first ones.
    #[test]
    fn first_systems_run_before_all_that_follow() {
        let mut schedule = Schedule::new(Frame);
        schedule
            .add_build_pass(FirstAfter {
                system: opaque.into_system_set().intern(),
                first: OpaquePicturePasses.intern(),
            })
            .add_systems((
                follower::<0>.after(opaque),
                follower::<1>.after(opaque),
                opaque,
                before.before(opaque),
            ))
            .add_systems(first.in_set(OpaquePicturePasses).after(opaque))
            .add_systems((
                asked.after(opaque).before(OpaquePicturePasses),
                follower::<2>.after(opaque),
                follower::<3>.after(follower::<0>),
            ));
        let first = ["before", "opaque", "asked", "first"];
        assert_eq!(run(schedule), [&first[..], &["follower"; 4]].concat());
    }

    /// Where an app has neither the system nor any that are to be first.
    #[test]
    fn a_schedule_without_them_is_left_alone() {
        let mut schedule = Schedule::new(Frame);
        schedule
            .add_build_pass(FirstAfter::opaque_pass())
            .add_systems((follower::<0>, opaque).chain());
        assert_eq!(run(schedule), ["follower", "opaque"]);
    }
}
