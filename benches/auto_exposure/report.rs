//! The Markdown table.

use core::fmt::Write;

use bevy::math::UVec2;
use serde::Serialize;

use crate::Args;
use kit::gpu_time::Time;

#[derive(Serialize, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    Copy,
    /// What nothing can be faster than.
    Bound,
    Lean,
    Pyramid,
    /// From spans around the passes in an app.
    InApp,
}

/// What was measured of one contender.
pub struct Measured {
    /// Each dispatch in a pass of its own.
    pub passes: Vec<Time>,
    /// All in one pass.
    pub whole: Option<Time>,
    pub luminance: f64,
}

#[derive(Serialize)]
pub struct Measurement {
    pub group: Group,
    pub contender: String,
    /// In milliseconds; none in an app.
    pub passes: Vec<Time>,
    /// All in one pass.
    pub whole: Option<Time>,
    /// That the first pass moves: of the pixels that it reads; for copies also of those that it writes.
    pub bytes: f64,
    pub luminance: Option<f64>,
    /// Of the metered luminance, relative to the mean in double precision over the whole picture.
    pub error: Option<f64>,
}

impl Measurement {
    /// That the first pass reaches.
    fn gigabytes_per_second(&self) -> Option<f64> {
        let first = self.passes.first().or(self.whole.as_ref())?.median;
        (self.bytes > 0.0 && first > 0.0).then(|| self.bytes / (first * 1e-3) * 1e-9)
    }
}

/// All of a size.
#[derive(Serialize)]
pub struct Table {
    pub adapter: String,
    pub size: UVec2,
    /// Textures that hold the picture.
    pub pictures: usize,
    pub measurements: Vec<Measurement>,
}

pub fn header(args: &Args) -> String {
    format!(
        "Median of {} frames (10th–90th percentile) in µs; all: the dispatches in one pass. GB/s: bytes of the pixels that the \
         first pass reads (copies: also of those written) over its time; %: of the faster copy. Error: of the metered \
         luminance, relative to the mean in double precision over the whole picture. In an app, times are from the span \
         around both dispatches, and so are GB/s.\n",
        args.frames
    )
}

pub fn markdown(table: &Table) -> String {
    let copy = table
        .measurements
        .iter()
        .filter(|m| m.group == Group::Copy)
        .filter_map(Measurement::gigabytes_per_second)
        .fold(0.0, f64::max);
    let mut text = format!(
        "**{}×{}**, {}, the picture in {} textures\n\n\
         | contender | pass 1 | pass 2 | pass 3 | all | GB/s | % of copy | relative error |\n\
         |---|---|---|---|---|---|---|---|\n",
        table.size.x, table.size.y, table.adapter, table.pictures
    );
    for m in &table.measurements {
        let rate = m.gigabytes_per_second();
        let figure = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.1}"));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} |",
            m.contender,
            microseconds(m.passes.first()),
            microseconds(m.passes.get(1)),
            microseconds(m.passes.get(2)),
            microseconds(m.whole.as_ref()),
            figure(rate),
            figure(rate.map(|rate| 100.0 * rate / copy)),
            m.error.map_or("–".into(), error),
        );
    }
    text
}

fn microseconds(time: Option<&Time>) -> String {
    time.map_or("–".into(), |t| {
        let [median, low, high] = [t.median, t.low, t.high].map(|time| time * 1e3);
        format!("{median:.1} ({low:.1}–{high:.1})")
    })
}

/// Large ones also in stops.
fn error(relative: f64) -> String {
    if relative.abs() < 1e-3 {
        format!("{relative:+.1e}")
    } else {
        format!("{relative:+.1e} ({:+.3} stops)", (1.0 + relative).log2())
    }
}
