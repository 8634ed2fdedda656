//! Orders this crate's passes among those of apps and other crates.
//!
//! Bevy records a camera's passes in parallel and submits them in the order of the sorted schedule. The first pass that
//! is *recorded* clears colour and depth. Two unordered passes race: the later one may clear the output of the earlier.
//! Each rule here orders passes of this crate against passes that have no order against them.

use core::iter;

use bevy::{
    core_pipeline::{
        core_3d::{main_opaque_pass_3d, main_transparent_pass_3d},
        prepass::node::{early_prepass, late_prepass},
        schedule::{Core2dSystems, Core3dSystems},
    },
    ecs::schedule::{
        FlattenedDependencies, InternedSystemSet, NodeId, ScheduleBuildError, ScheduleBuildPass,
        ScheduleGraph, SystemKey, SystemSetKey,
        graph::{DiGraph, Direction},
    },
    pbr::{EARLY_SHADOW_PASS, LATE_SHADOW_PASS, per_view_shadow_pass, shared_shadow_pass},
    platform::{collections::HashSet, hash::FixedHasher},
    prelude::*,
};
use indexmap::IndexSet;

use super::schedule::{
    DebugViewPasses, ExposureOverlayPasses, ExposurePasses, GBufferPasses, HistoryPasses,
    IndirectLightPasses, LightingPasses, OpaquePicturePasses,
};

/// Orders the systems of some sets before or after others that have no order against them. The others may belong to
/// other crates, which do not know these sets and whose private systems cannot be named.
///
/// One per schedule: build passes are identified by their type.
#[derive(Debug)]
pub(super) struct PassOrder(Vec<Rule>);

/// Adds an order between unordered systems. Rules apply in sequence: an earlier one takes precedence.
#[derive(Debug)]
struct Rule {
    /// Selects the members of all of these sets.
    ours: Vec<InternedSystemSet>,
    side: Side,
    others: Others,
}

/// The side of the others on which ours run.
#[derive(Clone, Copy, Debug)]
enum Side {
    Before,
    After,
}

/// The systems that ours are ordered against.
#[derive(Debug)]
enum Others {
    All,
    /// Systems ordered directly after the members of a set.
    Following(InternedSystemSet),
    /// Systems that run before all systems within a set, except members of the listed sets.
    Preceding(InternedSystemSet, Vec<InternedSystemSet>),
    /// Systems of a set, or of sets within it.
    Within(InternedSystemSet),
    /// Systems of ours that were added later.
    LaterOfOurs,
}

impl PassOrder {
    pub(super) fn of_core_3d() -> Self {
        let prepass_gbuffer = [GBufferPasses.intern(), Core3dSystems::Prepass.intern()];
        let main_pass = Core3dSystems::MainPass.intern();
        let mut rules = vec![
            // Readers of the prepass must see lean meshes in it.
            Rule::before(&prepass_gbuffer, following(early_prepass)),
            Rule::before(&prepass_gbuffer, following(late_prepass)),
            // The G-buffer is cleared if others have drawn depth, and its meshes are tested against that depth. A pass
            // between G-buffer and lighting would be overwritten by the lighting of meshes that it occludes.
            Rule::after(
                &[GBufferPasses.intern()],
                Others::Preceding(LightingPasses.intern(), shadow_passes()),
            ),
            // Passes before Bevy's opaque pass, in the main pass or in no set, draw among lit meshes, as among those
            // that Bevy draws.
            Rule::before(&[LightingPasses.intern()], Others::All),
            // Before Bevy's `render_sky`, which draws the air in front of meshes.
            Rule::before(
                &[OpaquePicturePasses.intern()],
                following(main_opaque_pass_3d),
            ),
            // History and debug views need the complete picture: after `oit_resolve`.
            Rule::after(&[HistoryPasses.intern()], Others::Within(main_pass)),
            Rule::after(&[DebugViewPasses.intern()], Others::Within(main_pass)),
        ];
        for set in [HistoryPasses.intern(), DebugViewPasses.intern()] {
            rules.push(Rule::before(&[set], following(main_transparent_pass_3d)));
        }
        for set in [
            IndirectLightPasses.intern(),
            OpaquePicturePasses.intern(),
            DebugViewPasses.intern(),
        ] {
            rules.push(Rule::before(&[set], Others::LaterOfOurs));
        }
        rules.extend(Rule::of_exposure(Core3dSystems::PostProcess.intern()));
        Self(rules)
    }

    pub(super) fn of_core_2d() -> Self {
        Self(Rule::of_exposure(Core2dSystems::PostProcess.intern()).into())
    }
}

fn following<M>(system: impl IntoSystemSet<M>) -> Others {
    Others::Following(system.into_system_set().intern())
}

/// Shadow passes draw nothing into the view. They take less time if recorded in parallel with the prepass.
pub(crate) fn shadow_passes() -> Vec<InternedSystemSet> {
    vec![
        per_view_shadow_pass::<EARLY_SHADOW_PASS>
            .into_system_set()
            .intern(),
        per_view_shadow_pass::<LATE_SHADOW_PASS>
            .into_system_set()
            .intern(),
        shared_shadow_pass::<EARLY_SHADOW_PASS>
            .into_system_set()
            .intern(),
        shared_shadow_pass::<LATE_SHADOW_PASS>
            .into_system_set()
            .intern(),
    ]
}

impl Rule {
    fn before(ours: &[InternedSystemSet], others: Others) -> Self {
        let (ours, side) = (ours.to_vec(), Side::Before);
        Self { ours, side, others }
    }

    fn after(ours: &[InternedSystemSet], others: Others) -> Self {
        let (ours, side) = (ours.to_vec(), Side::After);
        Self { ours, side, others }
    }

    /// Meters exposure in the input of post-processing. The overlay comes last, so that it is neither smoothed nor
    /// sharpened.
    fn of_exposure(post_process: InternedSystemSet) -> [Self; 2] {
        [
            Self::after(
                &[ExposurePasses.intern()],
                Others::Preceding(post_process, Vec::new()),
            ),
            Self::after(
                &[ExposureOverlayPasses.intern()],
                Others::Within(post_process),
            ),
        ]
    }

    fn apply(&self, graph: &ScheduleGraph, dependencies: &mut FlattenedDependencies<'_>) {
        let ours = members_of_all(graph, &self.ours);
        let others = self.others.systems(graph, dependencies.graph());
        for (place, &one) in ours.iter().enumerate() {
            let peers = match self.others {
                Others::LaterOfOurs => &ours[place + 1..],
                _ => &[],
            };
            // Edges from `one` do not change the systems that lead to it, and vice versa: no edge closes a cycle.
            let ordered = [Direction::Incoming, Direction::Outgoing]
                .map(|direction| reachable(dependencies.graph(), one, direction));
            let is_foreign = |other: &&SystemKey| !ours.contains(other);
            for &other in others.iter().filter(is_foreign).chain(peers) {
                if ordered.iter().any(|systems| systems.contains(&other)) {
                    continue;
                }
                match self.side {
                    Side::Before => dependencies.add_edge(one, other),
                    Side::After => dependencies.add_edge(other, one),
                }
            }
        }
    }
}

impl Others {
    fn systems(&self, graph: &ScheduleGraph, dependencies: &DiGraph<SystemKey>) -> Vec<SystemKey> {
        match self {
            Self::All => dependencies.nodes().collect(),
            Self::Following(set) => members(graph, *set)
                .into_iter()
                .flat_map(|system| dependencies.neighbors(system))
                .collect(),
            Self::Preceding(set, except) => {
                let ancestors = systems_within(graph, *set)
                    .into_iter()
                    .map(|system| reachable(dependencies, system, Direction::Incoming));
                let mut preceding = ancestors
                    .reduce(|mut all, these| {
                        all.retain(|system| these.contains(system));
                        all
                    })
                    .unwrap_or_default();
                for set in except {
                    for system in members(graph, *set) {
                        preceding.remove(&system);
                    }
                }
                // This order does not depend on hashes.
                let is_preceding = |system: &SystemKey| preceding.contains(system);
                dependencies.nodes().filter(is_preceding).collect()
            }
            Self::Within(set) => systems_within(graph, *set),
            Self::LaterOfOurs => Vec::new(),
        }
    }
}

/// Systems put directly into `set`, in the order in which they were added, which the graph of sets does not keep.
fn members(graph: &ScheduleGraph, set: InternedSystemSet) -> Vec<SystemKey> {
    let Some(set) = graph.system_sets.get_key(set) else {
        return Vec::new();
    };
    let children = graph.hierarchy().graph().neighbors(NodeId::Set(set));
    let mut systems: Vec<SystemKey> = children.filter_map(|child| child.as_system()).collect();
    systems.sort_unstable();
    systems
}

fn members_of_all(graph: &ScheduleGraph, sets: &[InternedSystemSet]) -> Vec<SystemKey> {
    let mut sets = sets.iter().map(|set| members(graph, *set));
    let mut systems = sets.next().unwrap_or_default();
    for set in sets {
        systems.retain(|system| set.contains(system));
    }
    systems
}

/// Systems put into `set`, or into a set within it.
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

/// All systems that are reachable from `from` along edges of one direction.
fn reachable(
    graph: &DiGraph<SystemKey>,
    from: SystemKey,
    direction: Direction,
) -> HashSet<SystemKey> {
    let mut seen = HashSet::default();
    let mut next = vec![from];
    while let Some(system) = next.pop() {
        let neighbors = graph.neighbors_directed(system, direction);
        next.extend(neighbors.filter(|neighbor| seen.insert(*neighbor)));
    }
    seen
}

impl ScheduleBuildPass for PassOrder {
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
        for rule in &self.0 {
            rule.apply(graph, &mut dependencies);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use bevy::{
        core_pipeline::schedule::Core3dSystems::{
            EarlyPostProcess, MainPass, PostProcess, Prepass,
        },
        ecs::{
            schedule::{ScheduleConfigs, ScheduleLabel},
            system::ScheduleSystem,
        },
        prelude::*,
    };

    use super::{
        ExposureOverlayPasses, ExposurePasses, GBufferPasses, HistoryPasses, LightingPasses,
        OpaquePicturePasses, Others, PassOrder, Rule, following,
    };

    #[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
    struct Frame;

    #[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
    struct Inner;

    #[derive(Resource, Default)]
    struct Ran(Vec<&'static str>);

    /// Systems that record their runs.
    macro_rules! noted {
        ($($name:ident),*) => {
            $(fn $name(mut ran: ResMut<Ran>) {
                ran.0.push(stringify!($name));
            })*
        };
    }

    noted!(
        other,
        asked,
        before,
        early_prepass,
        gbuffer,
        lighting,
        opaque,
        first,
        transparent,
        history,
        metering,
        bloom,
        overlay
    );

    fn follower<const N: u32>(mut ran: ResMut<Ran>) {
        ran.0.push("follower");
    }

    /// Names of the systems that ran, in order.
    fn run(mut schedule: Schedule) -> Vec<&'static str> {
        let mut world = World::new();
        world.init_resource::<Ran>();
        schedule.run(&mut world);
        core::mem::take(&mut world.resource_mut::<Ran>().0)
    }

    /// Runs the frame with `other` added before and after all else.
    fn run_with(other: impl Fn() -> ScheduleConfigs<ScheduleSystem>) -> [Vec<&'static str>; 2] {
        [true, false].map(|is_before| {
            let mut schedule = Schedule::new(Frame);
            let mut rules = PassOrder::of_core_3d();
            rules.0.insert(
                0,
                Rule::before(
                    &[GBufferPasses.intern(), Prepass.intern()],
                    following(early_prepass),
                ),
            );
            schedule.add_build_pass(rules);
            schedule.configure_sets((Prepass, MainPass, EarlyPostProcess, PostProcess).chain());
            if is_before {
                schedule.add_systems(other());
            }
            schedule.add_systems((
                early_prepass.in_set(Prepass),
                gbuffer
                    .in_set(GBufferPasses)
                    .in_set(Prepass)
                    .after(early_prepass),
                lighting
                    .in_set(LightingPasses)
                    .in_set(MainPass)
                    .before(opaque),
                (opaque, transparent).chain().in_set(MainPass),
                history
                    .in_set(HistoryPasses)
                    .in_set(MainPass)
                    .after(transparent),
                metering
                    .in_set(ExposurePasses)
                    .after(EarlyPostProcess)
                    .before(PostProcess),
                bloom.in_set(PostProcess),
                overlay.in_set(ExposureOverlayPasses).in_set(PostProcess),
            ));
            if !is_before {
                schedule.add_systems(other());
            }
            run(schedule)
        })
    }

    /// The system that runs right after `other`, if that was added before or after all else.
    fn next_of(other: impl Fn() -> ScheduleConfigs<ScheduleSystem>) -> [&'static str; 2] {
        run_with(other).map(|ran| {
            let place = ran.iter().position(|name| *name == "other");
            ran[place.expect("it runs") + 1]
        })
    }

    fn next(other: fn() -> ScheduleConfigs<ScheduleSystem>) -> &'static str {
        let [before, after] = next_of(other);
        assert_eq!(before, after);
        before
    }

    #[test]
    fn passes_of_others_have_their_place() {
        // The G-buffer is not drawn yet. Bevy's prepass has no order against such a pass.
        let early = |next: &str| ["early_prepass", "gbuffer"].contains(&next);
        assert!(next_of(|| other.in_set(Prepass)).into_iter().all(early));
        assert!(next_of(|| other.before(MainPass)).into_iter().all(early));
        // The G-buffer is drawn and lit.
        assert_eq!(next(|| other.before(opaque)), "opaque");
        assert_eq!(next(|| other.in_set(MainPass).before(opaque)), "opaque");
        assert_eq!(
            next(|| other.after(opaque).before(transparent)),
            "transparent"
        );
        // Readers of the prepass see all of the G-buffer.
        assert_eq!(
            next(|| other.in_set(Prepass).after(early_prepass)),
            "lighting"
        );
        // The picture is complete.
        assert_eq!(
            next(|| other.in_set(MainPass).after(transparent)),
            "history"
        );
        assert_eq!(next(|| other.in_set(EarlyPostProcess)), "metering");
        assert_eq!(
            next(|| other.before(PostProcess).after(EarlyPostProcess)),
            "metering"
        );
        assert_eq!(next(|| other.in_set(PostProcess).after(bloom)), "overlay");
    }

    /// An order that is requested by name is kept.
    #[test]
    fn passes_of_others_can_choose() {
        assert_eq!(
            next(|| other.before(LightingPasses).after(GBufferPasses)),
            "lighting"
        );
        assert_eq!(
            next(|| other.in_set(MainPass).after(HistoryPasses)),
            "metering"
        );
        assert_eq!(
            next(|| other.after(GBufferPasses).before(MainPass)),
            "lighting"
        );
    }

    /// Following systems are added before and after, and one of them requests to run before the first ones.
    #[test]
    fn first_systems_run_before_all_that_follow() {
        let mut schedule = Schedule::new(Frame);
        schedule
            .add_build_pass(PassOrder(vec![Rule::before(
                &[OpaquePicturePasses.intern()],
                following(opaque),
            )]))
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

    /// Others are added before and after, into the set or into one within it, and one requests to run before.
    #[test]
    fn first_systems_run_before_all_others_of_the_set() {
        let mut schedule = Schedule::new(Frame);
        schedule
            .add_build_pass(PassOrder::of_core_3d())
            .configure_sets(Inner.in_set(MainPass))
            .add_systems((follower::<0>.in_set(MainPass), follower::<1>.in_set(Inner)))
            .add_systems(first.in_set(LightingPasses).in_set(MainPass))
            .add_systems((
                follower::<2>.in_set(MainPass),
                follower::<3>.in_set(Inner),
                asked.in_set(MainPass).before(LightingPasses),
            ));
        let expected = [&["asked", "first"][..], &["follower"; 4]].concat();
        assert_eq!(run(schedule), expected);
    }

    #[test]
    fn systems_of_one_set_run_as_they_were_added() {
        let mut schedule = Schedule::new(Frame);
        schedule
            .add_build_pass(PassOrder(vec![Rule::before(
                &[OpaquePicturePasses.intern()],
                Others::LaterOfOurs,
            )]))
            .add_systems(
                (first, asked, before, opaque, gbuffer, lighting).in_set(OpaquePicturePasses),
            );
        let expected = ["first", "asked", "before", "opaque", "gbuffer", "lighting"];
        assert_eq!(run(schedule), expected);
    }

    /// An app may lack both our systems and those that they are ordered against.
    #[test]
    fn a_schedule_without_them_is_left_alone() {
        let mut schedule = Schedule::new(Frame);
        schedule
            .add_build_pass(PassOrder::of_core_3d())
            .add_systems((follower::<0>, opaque).chain());
        assert_eq!(run(schedule), ["follower", "opaque"]);
    }
}
