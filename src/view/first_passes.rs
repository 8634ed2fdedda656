//! Passes that come first among others, of whatever crate.

use core::iter;

use bevy::{
    core_pipeline::{core_3d::main_opaque_pass_3d, schedule::Core3dSystems},
    ecs::schedule::{
        FlattenedDependencies, InternedSystemSet, NodeId, ScheduleBuildError, ScheduleBuildPass,
        ScheduleGraph, SystemKey, SystemSetKey, graph::DiGraph,
    },
    platform::hash::FixedHasher,
    prelude::*,
};
use indexmap::IndexSet;

use super::schedule::{LightingPasses, OpaquePicturePasses};

/// Has all systems of some sets run before others, but those that are asked to run before them. The others may be of other crates, which
/// know nothing of these, and cannot be named where they are private.
///
/// A schedule has one of it: build passes are told apart by their type.
#[derive(Debug)]
pub(super) struct FirstPasses(Vec<Rule>);

#[derive(Debug)]
struct Rule {
    first: InternedSystemSet,
    others: Others,
}

/// Before whom.
#[derive(Debug)]
enum Others {
    /// Those that follow the systems of a set.
    After(InternedSystemSet),
    /// Those of a set, or of sets within it.
    Within(InternedSystemSet),
}

impl FirstPasses {
    pub(super) fn of_core_3d() -> Self {
        Self(vec![Rule::after_opaque_pass(), Rule::in_main_pass()])
    }
}

impl Rule {
    /// [`OpaquePicturePasses`] after Bevy's opaque pass: before its `render_sky`, which draws the air in front of meshes.
    fn after_opaque_pass() -> Self {
        Self {
            first: OpaquePicturePasses.intern(),
            others: Others::After(main_opaque_pass_3d.into_system_set().intern()),
        }
    }

    /// [`LightingPasses`] in Bevy's main pass. What others draw there, colour and depth, lies among the meshes that are lit, as among
    /// those that Bevy draws.
    fn in_main_pass() -> Self {
        Self {
            first: LightingPasses.intern(),
            others: Others::Within(Core3dSystems::MainPass.intern()),
        }
    }
}

impl Others {
    fn systems(&self, graph: &ScheduleGraph, dependencies: &DiGraph<SystemKey>) -> Vec<SystemKey> {
        match *self {
            Self::After(set) => systems_in(graph, set)
                .into_iter()
                .flat_map(|system| dependencies.neighbors(system))
                .collect(),
            Self::Within(set) => systems_within(graph, set),
        }
    }
}

/// Those that were put into `set` by name.
fn systems_in(graph: &ScheduleGraph, set: InternedSystemSet) -> Vec<SystemKey> {
    let Some(set) = graph.system_sets.get_key(set) else {
        return Vec::new();
    };
    let children = graph.hierarchy().graph().neighbors(NodeId::Set(set));
    children.filter_map(|child| child.as_system()).collect()
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

fn is_before(graph: &DiGraph<SystemKey>, one: SystemKey, other: SystemKey) -> bool {
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

impl ScheduleBuildPass for FirstPasses {
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
        for Rule { first, others } in &self.0 {
            let first = systems_in(graph, *first);
            for other in others.systems(graph, dependencies.graph()) {
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
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use bevy::{core_pipeline::schedule::Core3dSystems, ecs::schedule::ScheduleLabel, prelude::*};

    use super::{FirstPasses, LightingPasses, OpaquePicturePasses, Others, Rule};

    #[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
    struct Frame;

    #[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
    struct Inner;

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
            .add_build_pass(FirstPasses(vec![Rule {
                first: OpaquePicturePasses.intern(),
                others: Others::After(opaque.into_system_set().intern()),
            }]))
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

    /// Others were added before and after, into the set or into one within it, and one is asked to run before.
    #[test]
    fn first_systems_run_before_all_others_of_the_set() {
        let mut schedule = Schedule::new(Frame);
        schedule
            .add_build_pass(FirstPasses(vec![Rule::in_main_pass()]))
            .configure_sets(Inner.in_set(Core3dSystems::MainPass))
            .add_systems((
                follower::<0>.in_set(Core3dSystems::MainPass),
                follower::<1>.in_set(Inner),
            ))
            .add_systems(first.in_set(LightingPasses).in_set(Core3dSystems::MainPass))
            .add_systems((
                follower::<2>.in_set(Core3dSystems::MainPass),
                follower::<3>.in_set(Inner),
                asked.in_set(Core3dSystems::MainPass).before(LightingPasses),
            ));
        let expected = [&["asked", "first"][..], &["follower"; 4]].concat();
        assert_eq!(run(schedule), expected);
    }

    /// Where an app has neither the system nor any that are to be first.
    #[test]
    fn a_schedule_without_them_is_left_alone() {
        let mut schedule = Schedule::new(Frame);
        schedule
            .add_build_pass(FirstPasses::of_core_3d())
            .add_systems((follower::<0>, opaque).chain());
        assert_eq!(run(schedule), ["follower", "opaque"]);
    }
}
