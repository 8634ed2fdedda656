//! A progress bar with the time left.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::plan::Step;

/// Progress of the benches. A bench prints `[3/20]` when it begins the third of twenty steps.
pub struct Progress {
    bar: ProgressBar,
    /// Expected seconds of all steps.
    expected: f64,
    /// Expected seconds of the finished steps.
    done: f64,
    /// Actual seconds of the finished steps.
    took: f64,
    began: Instant,
}

/// Steps of the bar.
const LENGTH: u64 = 1000;

impl Progress {
    pub fn new(steps: &[Step]) -> Self {
        let bar = ProgressBar::new(LENGTH);
        let style = ProgressStyle::with_template("{bar:30} {msg}").expect("it is constant");
        bar.set_style(style);
        Self {
            bar,
            expected: steps.iter().map(|step| step.expected).sum(),
            done: 0.0,
            took: 0.0,
            began: Instant::now(),
        }
    }

    pub fn begin(&mut self, step: &Step) {
        self.began = Instant::now();
        self.show(step, 0.0, "");
        // Plain lines if the bar would be invisible.
        if self.bar.is_hidden() {
            eprintln!("{}", self.bar.message());
        }
    }

    /// Handles a line that a bench has written.
    pub fn line(&mut self, step: &Step, line: &str) {
        if let Some((share, what)) = counted(line) {
            self.show(step, share, what);
        }
    }

    pub fn end(&mut self, step: &Step) {
        self.done += step.expected;
        self.took += self.began.elapsed().as_secs_f64();
        let (bench, took) = (step.bench, self.began.elapsed().as_secs());
        self.bar.suspend(|| eprintln!("{bench}: {took} s"));
    }

    pub fn finish(self) {
        self.bar.finish_and_clear();
    }

    fn show(&self, step: &Step, share: f64, what: &str) {
        let so_far = self.took + self.began.elapsed().as_secs_f64();
        let left = left(so_far, self.done + share * step.expected, self.expected);
        let place = (self.done + share * step.expected) / self.expected.max(1.0);
        self.bar.set_position((place * LENGTH as f64) as u64);
        let minutes = left.as_secs().div_ceil(60);
        let what = if what.is_empty() { "…" } else { what };
        self.bar
            .set_message(format!("about {minutes} min left, {}: {what}", step.bench));
    }
}

/// The share of steps that are done, and the step that a line `[3/20] WHAT` announces.
fn counted(line: &str) -> Option<(f64, &str)> {
    let (count, what) = line.strip_prefix('[')?.split_once(']')?;
    let (number, of) = count.split_once('/')?;
    let [number, of] = [number, of].map(|text| text.parse::<u32>().ok().map(f64::from));
    let share = (number? - 1.0).max(0.0) / of?.max(1.0);
    Some((share.min(1.0), what.trim_start()))
}

/// The time left, after `so_far` seconds for `done` of `expected` seconds. The expectation weighs the more, the less is
/// done.
fn left(so_far: f64, done: f64, expected: f64) -> Duration {
    let pace = (so_far + BELIEF) / (done + BELIEF);
    Duration::from_secs_f64((pace * (expected - done)).max(0.0))
}

/// Seconds after which the measured pace weighs as much as the expected one.
const BELIEF: f64 = 20.0;

#[cfg(test)]
mod tests {
    use super::{counted, left};

    #[test]
    fn the_time_left_follows_the_pace() {
        assert_eq!(left(0.0, 0.0, 600.0).as_secs(), 600);
        // Twice as slow as expected.
        let slow = left(600.0, 300.0, 600.0).as_secs();
        assert!((550..600).contains(&slow), "{slow}");
        assert_eq!(left(700.0, 600.0, 600.0).as_secs(), 0);
    }

    #[test]
    fn lines_count_steps() {
        assert_eq!(counted("[6/20] a scene"), Some((0.25, "a scene")));
        assert_eq!(counted("[0/0]"), Some((0.0, "")));
        assert_eq!(counted("[a/b] [1/2]"), None);
        assert_eq!(counted("a warning [1/2]"), None);
    }
}
