//! CPU time of the render world, stage by stage.

use core::array;
use std::time::Instant;

use bevy::{
    app::SubApp,
    prelude::*,
    render::{Render, RenderSystems},
};

/// The stages, each up to the end of its system set.
const STAGES: [(&str, RenderSystems); 7] = [
    ("extract and assets", RenderSystems::PrepareMeshes),
    ("views", RenderSystems::CreateViews),
    ("specialize", RenderSystems::Specialize),
    ("queue", RenderSystems::QueueMeshes),
    ("sort", RenderSystems::PhaseSort),
    ("prepare", RenderSystems::Prepare),
    ("render", RenderSystems::Render),
];

/// Milliseconds per stage. Extraction counts with the first.
pub type StageTimes = [f64; STAGES.len()];

/// End of each stage in the last frame.
#[derive(Resource, Default)]
struct Marks([Option<Instant>; STAGES.len()]);

/// Adds systems that record the ends of the stages.
pub fn record(render_app: &mut SubApp) {
    render_app.init_resource::<Marks>();
    for (place, (_, stage)) in STAGES.iter().enumerate() {
        let mark = move |mut marks: ResMut<Marks>| marks.0[place] = Some(Instant::now());
        match STAGES.get(place + 1) {
            Some((_, next)) => {
                render_app.add_systems(Render, mark.after(stage.clone()).before(next.clone()));
            }
            None => {
                render_app.add_systems(Render, mark.after(stage.clone()));
            }
        }
    }
}

/// Times of the last frame, whose extraction began at `began`.
pub fn times(render_app: &SubApp, began: Instant) -> StageTimes {
    let marks = render_app.world().resource::<Marks>().0;
    let mut before = began;
    array::from_fn(|place| {
        let Some(end) = marks[place] else {
            return f64::NAN;
        };
        let milliseconds = end.duration_since(before).as_secs_f64() * 1e3;
        before = end;
        milliseconds
    })
}

/// Median of each stage, with its name.
pub fn medians(times: &[StageTimes]) -> Vec<(String, f64)> {
    let of = |stage: usize| {
        let mut values: Vec<f64> = times.iter().map(|times| times[stage]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let names = STAGES.iter().enumerate();
    names
        .map(|(stage, (name, _))| ((*name).into(), of(stage)))
        .collect()
}
