//! Frame times and their statistics.

use core::fmt::{Display, Formatter, Result};
use core::mem;

/// Frame times in milliseconds.
#[derive(Clone, Debug, Default)]
pub struct FrameTimes(Vec<f64>);

impl FrameTimes {
    fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    /// Nearest-rank percentile: the time that `share` of the frames do not exceed.
    fn percentile(&self, share: f64) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        let rank = (share * sorted.len() as f64).ceil() as usize;
        let last = sorted.len().saturating_sub(1);
        sorted
            .get(rank.saturating_sub(1).min(last))
            .copied()
            .unwrap_or(f64::NAN)
    }
}

/// Prints each statistic in milliseconds and as frames per second.
impl Display for FrameTimes {
    fn fmt(&self, f: &mut Formatter) -> Result {
        if self.0.is_empty() {
            return write!(f, "no frames");
        }
        write!(f, "{} frames", self.0.len())?;
        for (name, time) in [
            ("mean", self.mean()),
            ("median", self.percentile(0.5)),
            ("99th percentile", self.percentile(0.99)),
        ] {
            write!(f, ", {name} {time:.3} ms ({:.1} fps)", 1000.0 / time)?;
        }
        Ok(())
    }
}

/// Milliseconds between two reports.
const INTERVAL: f64 = 3000.0;

/// All frames, and those since the last report.
#[derive(Clone, Debug, Default)]
pub struct FrameReports {
    pub all: FrameTimes,
    recent: FrameTimes,
    since_last: f64,
}

impl FrameReports {
    /// Adds a frame. Returns the recent frames when a report is due.
    pub fn add(&mut self, milliseconds: f64) -> Option<FrameTimes> {
        self.all.0.push(milliseconds);
        self.recent.0.push(milliseconds);
        self.since_last += milliseconds;
        if self.since_last < INTERVAL {
            return None;
        }
        self.since_last = 0.0;
        Some(mem::take(&mut self.recent))
    }
}
