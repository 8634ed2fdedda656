//! GPU times of spans, and systems that open and close spans.

use bevy::{
    diagnostic::DiagnosticsStore,
    platform::{collections::HashMap, time::Instant},
    prelude::*,
    render::{diagnostic::RecordDiagnostics, renderer::RenderContext},
};
pub use figures::time::Time;

/// GPU times by span name.
pub struct Samples {
    times: HashMap<String, Vec<f64>>,
    /// Start of recording. Older measurements are skipped: spans that are no longer opened keep their last value.
    began: Instant,
}

impl Default for Samples {
    fn default() -> Self {
        Self {
            times: HashMap::default(),
            began: Instant::now(),
        }
    }
}

impl Samples {
    /// Records the newest value of each span.
    pub fn take(&mut self, store: &DiagnosticsStore) {
        for diagnostic in store.iter() {
            let Some(name) = diagnostic.path().as_str().strip_suffix("/elapsed_gpu") else {
                continue;
            };
            let measured = diagnostic.measurement();
            if let Some(measured) = measured.filter(|measured| measured.time > self.began) {
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

    pub fn time(&self, name: &str) -> Option<Time> {
        Some(Time::of(self.times.get(name)?.clone()))
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
