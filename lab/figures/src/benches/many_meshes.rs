//! CPU time of a frame with many meshes.

use serde::{Deserialize, Serialize};

use super::{Figures, distinct};
use crate::{
    numbers::{fixed, thousands},
    plots::{Plot, bars::Bars, lines::Lines},
    table::Table,
    time::Device,
};

/// Milliseconds of CPU time.
#[derive(Serialize, Deserialize, Clone, Copy, Default)]
pub struct Times {
    pub render_world: f64,
    pub frame: f64,
}

#[derive(Serialize, Deserialize, Clone)]
pub struct Measurement {
    #[serde(flatten)]
    pub device: Device,
    #[serde(default)]
    pub size: Option<[u32; 2]>,
    #[serde(default)]
    pub frames: Option<usize>,
    pub cores: usize,
    pub meshes: usize,
    pub contender: String,
    /// Medians while nothing, a tenth and everything moves.
    pub steady: Vec<Times>,
    /// The most expensive of the frames after the emissive mesh appeared, after its target expired once it was hidden,
    /// and after the camera turned around: medians over the events.
    pub emissive: Times,
    pub expiry: Times,
    pub turn: Times,
    /// Milliseconds per stage, by name, of the frame in which the camera turns.
    pub turn_stages: Vec<(String, f64)>,
    /// Against forward; `None` for equal pictures.
    pub psnr: Option<f64>,
    pub flip: Option<f64>,
}

impl Measurement {
    /// All times, in the order of the columns.
    fn times(&self) -> Vec<Times> {
        let mut times = self.steady.clone();
        times.extend([self.emissive, self.expiry, self.turn]);
        times
    }
}

#[derive(Serialize, Deserialize, Default)]
#[serde(transparent)]
pub struct ManyMeshes(pub Vec<Measurement>);

/// The reference of ratios.
const PEER: &str = "Bevy deferred";

const COLUMNS: [&str; 10] = [
    "meshes",
    "renderer",
    "static",
    "a tenth moves",
    "all move",
    "emissive mesh appears",
    "its target goes",
    "camera turns around",
    "PSNR dB",
    "FLIP",
];

impl ManyMeshes {
    pub fn join(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    /// A table of the render world, or of the whole frame.
    pub fn table(&self, of: fn(&Times) -> f64) -> Table {
        let row = |m: &Measurement| {
            let is_peer = |o: &&Measurement| o.meshes == m.meshes && o.contender == PEER;
            let peer = self.0.iter().find(is_peer).map(Measurement::times);
            let cell = |(index, times)| {
                let peer = peer.as_ref().and_then(|peer| peer.get(index));
                let ratio = peer.map(|peer| of(&times) / of(peer));
                format!("{} (× {})", fixed(of(&times), 2), fixed(ratio, 2))
            };
            let mut row = vec![thousands(m.meshes as u64), m.contender.clone()];
            row.extend(m.times().into_iter().enumerate().map(cell));
            // Forward is the reference.
            let errors = [(m.psnr, 1), (m.flip, 4)];
            row.extend(errors.map(|(error, digits)| {
                fixed(error.filter(|_| m.contender != "Bevy forward"), digits)
            }));
            row
        };
        Table::new(&COLUMNS, self.0.iter().map(row))
    }

    fn over_meshes(&self) -> Plot {
        let mut lines = Lines::new("meshes", "CPU time of the render world (ms)");
        for contender in distinct(self.0.iter().map(|m| m.contender.as_str())) {
            let of = |time: fn(&Measurement) -> f64| -> Vec<(f64, f64)> {
                let own = self.0.iter().filter(|m| m.contender == contender);
                own.map(|m| (m.meshes as f64, time(m))).collect()
            };
            let still = of(|m| m.steady.first().map_or(f64::NAN, |t| t.render_world));
            lines.add(format!("{contender}, static"), still, false);
            let moving = of(|m| m.steady.last().map_or(f64::NAN, |t| t.render_world));
            lines.add(format!("{contender}, all move"), moving, true);
        }
        lines.plot("meshes", "Cost over the number of meshes".into())
    }

    fn stages(&self) -> Option<Plot> {
        let most = self.0.iter().map(|m| m.meshes).max()?;
        let shown = || self.0.iter().filter(|m| m.meshes == most);
        let names: Vec<&str> = (shown().next()?.turn_stages.iter())
            .map(|(name, _)| name.as_str())
            .collect();
        let mut bars = Bars::new("CPU time (ms)", &names);
        for m in shown() {
            let parts = m.turn_stages.iter().map(|(_, time)| *time);
            bars.add(m.contender.clone(), parts.collect());
        }
        let title = format!("Stages of the render world in the frame of a turn, {most} meshes");
        Some(bars.plot("stages", title))
    }
}

impl Figures for ManyMeshes {
    fn device(&self) -> Device {
        (self.0.first()).map_or(Device::default(), |m| m.device.clone())
    }

    fn tables(&self) -> Vec<Table> {
        vec![
            self.table(|times| times.render_world)
                .titled("**Render world**"),
            self.table(|times| times.frame).titled("**Whole frame**"),
        ]
    }

    fn legend(&self) -> String {
        let first = self.0.first();
        let cores = first.map_or(0, |m| m.cores);
        let size = first
            .and_then(|m| m.size)
            .map(|[x, y]| format!(", {x}×{y}"));
        format!(
            "{cores} cores{}. CPU time in ms; × is to Bevy deferred. Events: the dearest of the frames in which something \
             follows from them, medians. Errors against forward",
            size.unwrap_or_default()
        )
    }

    fn plots(&self) -> Vec<Plot> {
        let mut plots = vec![self.over_meshes()];
        plots.extend(self.stages());
        plots
    }
}
