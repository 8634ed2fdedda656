//! Measures one walk.

use std::{
    thread::sleep,
    time::{Duration, Instant},
};

use bevy::math::UVec2;
use figures::{
    benches::stutter::{self, Measurement, Pipelines},
    time::Time,
};
use kit::{
    renderer::Renderer,
    walk::{Event, Walk},
};

/// A renderer, with or without effects.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    Plain(Renderer),
    /// Lean, with diffuse GI and reflections.
    LeanWithEffects,
}

impl Contender {
    pub const ALL: [Self; 4] = [
        Self::Plain(Renderer::Forward),
        Self::Plain(Renderer::BevyDeferred),
        Self::Plain(Renderer::Lean),
        Self::LeanWithEffects,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Plain(renderer) => renderer.name(),
            Self::LeanWithEffects => "lean with GI and reflections",
        }
    }

    fn renderer(self) -> Renderer {
        match self {
            Self::Plain(renderer) => renderer,
            Self::LeanWithEffects => Renderer::Lean,
        }
    }
}

/// Extent of a walk.
#[derive(Clone, Copy)]
pub struct Extent {
    pub size: UVec2,
    pub frames: usize,
    /// Most frames per second; 0 for no limit.
    pub fps: f64,
}

/// Longest wait for what is still compiled after a walk.
const PATIENCE: Duration = Duration::from_secs(60);

/// Loads the level, and walks through it. Events are evenly spread over the frames, and there are at least as many frames as events.
pub fn measure(contender: Contender, synchronous: bool, extent: Extent) -> Measurement {
    let mut walk = Walk::new(contender.renderer(), extent.size, synchronous);
    let has_effects = contender == Contender::LeanWithEffects;
    if has_effects {
        walk.add_effects();
    }
    walk.step();
    walk.headless.settle();
    let loading = walk.requested_pipelines();

    let events = Event::all();
    let count = extent.frames.max(events.len());
    let mut seen = Seen::default();
    for frame in 0..count {
        if seen.events.len() * count <= frame * events.len() {
            let event = events[seen.events.len()];
            walk.apply(event);
            seen.events.push(stutter::Event {
                name: event.name(),
                ..Default::default()
            });
        }
        let start = Instant::now();
        walk.step();
        let took = start.elapsed();
        seen.take(&mut walk, took);
        // At the rate of a screen: pipelines are compiled meanwhile.
        if extent.fps > 0.0 {
            sleep(Duration::from_secs_f64(1.0 / extent.fps).saturating_sub(start.elapsed()));
        }
    }

    let requested = walk.requested_pipelines().into_iter();
    let pipelines = requested.map(|(label, requested)| {
        let loading = loading.get(&label).copied().unwrap_or_default();
        Pipelines {
            label,
            loading,
            walk: requested - loading,
        }
    });
    let pipelines = pipelines.collect();
    let device = walk.headless.adapter_and_driver();
    let end = Instant::now();
    while walk.headless.is_compiling() && end.elapsed() < PATIENCE {
        walk.headless.frame();
    }

    let [median, longest, hitches] = seen.hitches();
    let events = seen.events;
    let sum = |of: fn(&stutter::Event) -> usize| events.iter().map(of).sum::<usize>();
    let is_lean = contender.renderer() == Renderer::Lean;
    Measurement {
        device,
        cores: std::thread::available_parallelism().map_or(0, usize::from),
        size: extent.size.to_array(),
        frames: count,
        contender: contender.name().into(),
        synchronous,
        pipelines,
        not_lean: is_lean.then(|| sum(|event| event.not_lean)),
        waiting_meshes: is_lean.then(|| sum(|event| event.waiting_meshes)),
        lost_history: has_effects.then(|| sum(|event| event.lost_history)),
        median,
        longest,
        hitches,
        events: events.into_iter().filter(is_notable).collect(),
    }
}

fn is_notable(event: &stutter::Event) -> bool {
    let frames = event.not_lean + event.waiting_meshes + event.lost_history;
    frames > 0 || event.hitches > 0.0
}

/// Observations in the frames so far.
#[derive(Default)]
struct Seen {
    /// The events so far.
    events: Vec<stutter::Event>,
    /// Milliseconds of each frame, and the index of its event.
    frames: Vec<(f64, usize)>,
    was_lean: bool,
    had_history: bool,
}

impl Seen {
    /// Observes a frame. The first event comes before the first frame.
    fn take(&mut self, walk: &mut Walk, took: Duration) {
        let index = self.events.len() - 1;
        let event = &mut self.events[index];
        self.frames.push((took.as_secs_f64() * 1e3, index));
        let is_lean = walk.is_lean();
        let has_history = walk.follows_last_frame();
        event.not_lean += usize::from(self.was_lean && !is_lean);
        event.lost_history += usize::from(self.had_history && !has_history);
        event.waiting_meshes += usize::from(walk.waiting_meshes() > 0);
        self.was_lean |= is_lean;
        self.had_history |= has_history;
    }

    /// Median and longest time of a frame, and the sum of hitches, which are added to their events.
    fn hitches(&mut self) -> [f64; 3] {
        let times: Vec<f64> = self.frames.iter().map(|(time, _)| *time).collect();
        let longest = times.iter().copied().fold(0.0, f64::max);
        let median = Time::of(times).median;
        for (time, event) in &self.frames {
            self.events[*event].hitches += (time - 2.0 * median).max(0.0);
        }
        let hitches = self.events.iter().map(|event| event.hitches);
        [median, longest, hitches.sum()]
    }
}
