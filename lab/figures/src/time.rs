//! Times, and the devices that they were measured on.

use serde::{Deserialize, Serialize};

/// Median and spread of a time, in milliseconds.
#[derive(Serialize, Deserialize, Clone, Copy, Default, Debug)]
pub struct Time {
    pub median: f64,
    /// 10th and 90th percentile.
    pub low: f64,
    pub high: f64,
}

impl Time {
    /// Median and spread of times in milliseconds, at least one.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        Self {
            median: at(0.5),
            low: at(0.1),
            high: at(0.9),
        }
    }

    /// Text for progress output.
    pub fn text(time: Option<Self>) -> String {
        time.map_or("–".into(), |t| {
            format!("{:.3} ({:.3}–{:.3})", t.median, t.low, t.high)
        })
    }
}

/// The graphics adapter, and its driver.
#[derive(Serialize, Deserialize, Clone, Default, Debug, PartialEq, Eq)]
pub struct Device {
    pub adapter: String,
    /// Includes its version. Empty in older files.
    #[serde(default)]
    pub driver: String,
}

impl core::fmt::Display for Device {
    fn fmt(&self, f: &mut core::fmt::Formatter) -> core::fmt::Result {
        match self.driver.is_empty() {
            true => f.write_str(&self.adapter),
            false => write!(f, "{} ({})", self.adapter, self.driver),
        }
    }
}
