//! GPU time, bandwidth and error of auto exposure.

use serde::{Deserialize, Serialize};

use super::{Figures, only};
use crate::{
    numbers::{fixed, time_us},
    plots::{Plot, bars::Bars, points::Points},
    table::Table,
    time::{Device, Time},
};

#[derive(Serialize, Deserialize, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Group {
    Copy,
    /// A lower bound of all times.
    Bound,
    Lean,
    Pyramid,
    /// Measured by spans around the passes in an app.
    InApp,
}

#[derive(Serialize, Deserialize, Clone)]
pub struct Measurement {
    pub group: Group,
    pub contender: String,
    /// Times of the dispatches, each in its own pass, in milliseconds; empty in an app.
    pub passes: Vec<Time>,
    /// Time of all dispatches in one pass.
    pub whole: Option<Time>,
    /// Bytes that the first pass moves: those of the picture; for copies also those that it writes.
    pub bytes: f64,
    pub luminance: Option<f64>,
    /// Error of the metered luminance, relative to the mean in double precision over the whole picture.
    pub error: Option<f64>,
}

impl Measurement {
    /// Bandwidth of the first pass.
    pub fn gigabytes_per_second(&self) -> Option<f64> {
        let first = self.passes.first().or(self.whole.as_ref())?.median;
        (self.bytes > 0.0 && first > 0.0).then(|| self.bytes / (first * 1e-3) * 1e-9)
    }

    /// The error; large ones also in stops.
    fn error_text(&self) -> String {
        match self.error {
            None => fixed(None, 0),
            Some(error) if error.abs() < 1e-3 => format!("{error:+.1e}"),
            Some(error) => format!("{error:+.1e} ({:+.3} stops)", (1.0 + error).log2()),
        }
    }
}

/// Measurements at one size.
#[derive(Serialize, Deserialize)]
pub struct Size {
    #[serde(flatten)]
    pub device: Device,
    #[serde(default)]
    pub frames: Option<usize>,
    pub size: [u32; 2],
    /// Number of textures that hold the picture.
    pub pictures: usize,
    pub measurements: Vec<Measurement>,
}

#[derive(Serialize, Deserialize, Default)]
#[serde(transparent)]
pub struct AutoExposure(pub Vec<Size>);

const COLUMNS: [&str; 8] = [
    "contender",
    "pass 1",
    "pass 2",
    "pass 3",
    "all",
    "GB/s",
    "% of copy",
    "relative error",
];

impl Size {
    /// Bandwidth of the faster copy.
    fn copy(&self) -> f64 {
        (self.measurements.iter())
            .filter(|m| m.group == Group::Copy)
            .filter_map(Measurement::gigabytes_per_second)
            .fold(0.0, f64::max)
    }

    /// Bandwidth of the first pass, of that of the faster copy.
    pub fn percent_of_copy(&self, m: &Measurement) -> Option<f64> {
        Some(100.0 * m.gigabytes_per_second()? / self.copy())
    }

    #[track_caller]
    pub fn at(&self, contender: &str) -> &Measurement {
        let all = self.measurements.iter();
        only(all.filter(|m| m.contender == contender), contender)
    }

    fn table(&self) -> Table {
        let row = |m: &Measurement| {
            let pass = |pass: usize| time_us(m.passes.get(pass).copied());
            vec![
                m.contender.clone(),
                pass(0),
                pass(1),
                pass(2),
                time_us(m.whole),
                fixed(m.gigabytes_per_second(), 1),
                fixed(self.percent_of_copy(m), 1),
                m.error_text(),
            ]
        };
        let [x, y] = self.size;
        let title = format!("**{x}×{y}**, the picture in {} textures", self.pictures);
        Table::new(&COLUMNS, self.measurements.iter().map(row)).titled(title)
    }
}

impl AutoExposure {
    pub fn join(&mut self, more: Self) {
        for size in more.0 {
            match self.0.iter_mut().find(|own| own.size == size.size) {
                Some(own) => own.measurements.extend(size.measurements),
                None => self.0.push(size),
            }
        }
    }

    #[track_caller]
    pub fn at(&self, size: [u32; 2]) -> &Size {
        only(self.0.iter().filter(|own| own.size == size), size)
    }

    /// The size of 4K, or else the last.
    fn shown(&self) -> Option<&Size> {
        let large = self.0.iter().find(|size| size.size == [3840, 2160]);
        large.or(self.0.last())
    }

    fn title(&self, text: &str) -> String {
        let size = self.shown().map(|size| size.size);
        size.map_or(text.into(), |[x, y]| format!("{text}, {x}×{y}"))
    }

    fn metering(&self) -> impl Iterator<Item = &Measurement> {
        let measurements = self.shown().map_or(&[][..], |size| &size.measurements);
        let meters = |m: &&Measurement| !matches!(m.group, Group::Copy | Group::Bound);
        measurements.iter().filter(meters)
    }

    fn speed(&self) -> Plot {
        let mut points = Points::new(
            "GPU time of all passes (µs)",
            "relative error of the metered luminance",
        );
        for m in self.metering() {
            // The other path of the same settings has the same error, and about the same time.
            let is_other = |o: &Measurement| {
                m.contender.strip_suffix(", shared memory")
                    == o.contender.strip_suffix(", subgroups")
                    && m.contender.ends_with(", shared memory")
            };
            if self.metering().any(is_other) {
                continue;
            }
            if let (Some(whole), Some(error)) = (m.whole, m.error) {
                let (group, name) = label(m);
                // Below this the reference itself is not exact enough.
                points.add(group, &name, whole.median * 1e3, error.abs().max(1e-9));
            }
        }
        points.plot("speed", self.title("Speed against error of auto exposure"))
    }

    fn stages(&self) -> Plot {
        let mut bars = Bars::new(
            "GPU time (µs)",
            &["pass 1", "pass 2", "pass 3", "span in an app"],
        );
        for m in self.metering() {
            let mut parts: Vec<f64> = m.passes.iter().map(|time| time.median * 1e3).collect();
            parts.resize(3, 0.0);
            let in_app = m.group == Group::InApp;
            let span = m
                .whole
                .filter(|_| in_app)
                .map_or(0.0, |time| time.median * 1e3);
            parts.push(span);
            bars.add(m.contender.clone(), parts);
        }
        bars.plot("stages", self.title("Passes of auto exposure, each alone"))
    }
}

/// Group and name of a point.
fn label(m: &Measurement) -> (&'static str, String) {
    let name = m.contender.trim_start_matches("in an app: ");
    let bevys = name.strip_prefix("Bevy, ");
    let group = match (m.group, bevys) {
        (Group::InApp, Some(_)) => "Bevy, in an app",
        (Group::InApp, None) => "lean, in an app",
        (Group::Pyramid, _) => "pyramid of three passes",
        _ => "lean",
    };
    let name = bevys.unwrap_or(name);
    let name = name
        .replace("LogAverage", "log")
        .replace("LinearAverage", "linear")
        .replace("pyramid, ", "")
        .replace(", subgroups", "");
    (group, name)
}

impl Figures for AutoExposure {
    fn device(&self) -> Device {
        (self.0.first()).map_or(Device::default(), |size| size.device.clone())
    }

    fn tables(&self) -> Vec<Table> {
        self.0.iter().map(Size::table).collect()
    }

    fn legend(&self) -> String {
        let frames = self.0.first().and_then(|size| size.frames);
        format!(
            "Median{} (10th–90th percentile) in µs; all: the dispatches in one pass. GB/s: bytes of the pixels that the first \
             pass reads (copies: also of those written) over its time; %: of the faster copy. Error: of the metered \
             luminance, relative to the mean in double precision over the whole picture. In an app, times are from the span \
             around both dispatches, and so are GB/s",
            frames.map_or(String::new(), |n| format!(" of {n} frames"))
        )
    }

    fn plots(&self) -> Vec<Plot> {
        vec![self.speed(), self.stages()]
    }
}
