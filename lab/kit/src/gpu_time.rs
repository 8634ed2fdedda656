//! GPU times of spans, and systems that open and close spans.

use bevy::{
    diagnostic::DiagnosticsStore,
    platform::{collections::HashMap, time::Instant},
    prelude::*,
    render::{diagnostic::RecordDiagnostics, renderer::RenderContext},
};
pub use figures::time::Time;

use crate::headless::Headless;

/// GPU times by span name.
pub struct Samples {
    times: HashMap<String, Vec<f64>>,
    /// Invocations of fragment shaders, by the whole path of the span, in the last frame.
    fragments: HashMap<String, f64>,
    /// Start of recording. Older measurements are skipped: spans that are no longer opened keep their last value.
    began: Instant,
}

impl Default for Samples {
    fn default() -> Self {
        Self {
            times: HashMap::default(),
            fragments: HashMap::default(),
            began: Instant::now(),
        }
    }
}

impl Samples {
    /// Renders `warm_up` frames, and then those that it records.
    pub fn of_frames(headless: &mut Headless, warm_up: usize, frames: usize) -> Self {
        headless.frames(warm_up);
        let mut samples = Self::default();
        for _ in 0..frames {
            headless.frames(1);
            samples.take(headless.app.world().resource::<DiagnosticsStore>());
        }
        samples
    }

    /// Records the newest value of each span.
    pub fn take(&mut self, store: &DiagnosticsStore) {
        for diagnostic in store.iter() {
            let path = diagnostic.path().as_str();
            let measured = diagnostic.measurement();
            let measured = measured.filter(|measured| measured.time > self.began);
            let Some(measured) = measured else {
                continue;
            };
            if let Some(name) = path.strip_suffix("/fragment_shader_invocations") {
                self.fragments.insert(name.to_owned(), measured.value);
            }
            if let Some(name) = path.strip_suffix("/elapsed_gpu") {
                let name = name.trim_start_matches("render/");
                let name = name.strip_prefix("bench/camera/").unwrap_or(name);
                let name = name.strip_prefix("bench/prepass/").unwrap_or(name);
                // It may have run within any of Bevy's stages that the bench wraps in a span.
                let name = name.find("lean_deferred/").map_or(name, |at| &name[at..]);
                let times = self.times.entry(name.to_owned()).or_default();
                times.push(measured.value);
            }
        }
    }

    /// Sum per frame of all spans that `is_wanted` selects; none if it selects none.
    pub fn sum(&self, is_wanted: impl Fn(&str) -> bool) -> Option<Time> {
        let mut frames: Vec<f64> = Vec::new();
        for (_, times) in self.times.iter().filter(|(name, _)| is_wanted(name)) {
            frames.resize(frames.len().max(times.len()), 0.0);
            for (frame, time) in frames.iter_mut().zip(times) {
                *frame += time;
            }
        }
        (!frames.is_empty()).then(|| Time::of(frames))
    }

    /// As [`sum`](Self::sum), of the spans whose names begin with `prefix`. Spans within others of them count once.
    pub fn sum_within(&self, prefix: &str) -> Option<Time> {
        self.sum(|name| {
            let is_outer = |other: &String| {
                other.starts_with(prefix)
                    && (name.strip_prefix(other.as_str())).is_some_and(|rest| rest.starts_with('/'))
            };
            name.starts_with(prefix) && !self.times.keys().any(is_outer)
        })
    }

    /// Invocations of fragment shaders in passes within the span `name`; none if the device does not count them.
    pub fn fragments(&self, name: &str) -> Option<f64> {
        let within = self
            .fragments
            .iter()
            .filter(|(path, _)| path.contains(name));
        within.map(|(_, count)| *count).reduce(|a, b| a + b)
    }

    pub fn time(&self, name: &str) -> Option<Time> {
        Some(Time::of(self.times.get(name)?.clone()))
    }

    /// Names and medians of all spans, the longest first.
    pub fn medians(&self) -> Vec<(String, f64)> {
        let medians =
            (self.times.iter()).map(|(name, times)| (name.clone(), Time::of(times.clone()).median));
        let mut medians: Vec<_> = medians.collect();
        medians.sort_by(|(a, x), (b, y)| y.total_cmp(x).then_with(|| a.cmp(b)));
        medians
    }
}

/// A system that opens a span.
pub fn begin(mut ctx: RenderContext, name: &'static str) {
    let recorder = ctx.diagnostic_recorder();
    recorder
        .as_deref()
        .begin_time_span(ctx.command_encoder(), name.into());
}

/// A system that closes the innermost open span.
pub fn end(mut ctx: RenderContext) {
    let recorder = ctx.diagnostic_recorder();
    recorder.as_deref().end_time_span(ctx.command_encoder());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inner_spans_count_once() {
        let times = [
            ("effects/gi", 2.0),
            ("effects/gi/filter", 1.5),
            ("effects/gi_other", 0.5),
            ("lighting", 8.0),
        ];
        let samples = Samples {
            times: times
                .map(|(name, time)| (name.into(), vec![time]))
                .into_iter()
                .collect(),
            ..default()
        };
        let sum = samples.sum_within("effects/").expect("there are some");
        assert_eq!(sum.median, 2.5);
        assert!(samples.sum_within("nothing/").is_none());
        let (longest, _) = &samples.medians()[0];
        assert_eq!(longest, "lighting");
    }
}
