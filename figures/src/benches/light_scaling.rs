//! Cost of lighting over the number of lights.

mod plot;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Figures, distinct};
use crate::{
    json::figure,
    plots::Plot,
    record::{Record, size_key},
    table::Table,
    time::{Device, Time},
};

/// All measurements of a run.
#[derive(Serialize, Deserialize, Default)]
pub struct LightScaling {
    #[serde(flatten)]
    pub device: Device,
    /// Memory bandwidth of the GPU in TB/s, if known: for the line of the bandwidth limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bandwidth: Option<f64>,
    pub points: Vec<Point>,
}

/// One renderer with one number of lights.
#[derive(Serialize, Deserialize, Clone, Default)]
pub struct Point {
    pub size: [u32; 2],
    pub arrangement: String,
    pub lights: u32,
    pub contender: String,
    /// The reason, if it was not measured.
    pub left_out: Option<String>,
    pub frames: usize,
    /// Time of lighting; for forward, of the opaque pass with its lighting.
    pub stage: Option<Time>,
    /// Everything from the first to the last pass of the camera.
    pub camera: Option<Time>,
    /// The whole frame, from the start of its systems to the end of GPU work, by the CPU's clock.
    pub frame: Option<Time>,
    /// Against forward, in dB; `None` for forward itself, where that was not measured, and for equal pictures.
    pub psnr: Option<f64>,
    /// Bevy's clusters in the measured frames: each grid that was used, and the largest total of light indices.
    pub grids: Vec<[u32; 3]>,
    pub longest_list: usize,
    /// Bevy found its lists too short in a measured frame.
    pub lists_grew: bool,
}

/// The reference of the table's ratio.
const PEER: &str = "Bevy deferred";
pub const FORWARD: &str = "Bevy forward";

/// The measured stage of a contender: the one whose cost depends on the lights.
pub fn stage(contender: &str) -> &'static str {
    match contender {
        FORWARD => "opaque pass",
        _ => "lighting",
    }
}

impl Point {
    pub fn label(&self) -> String {
        let [width, height] = self.size;
        let (arrangement, lights) = (&self.arrangement, self.lights);
        format!("{width}x{height} {arrangement} {lights} {}", self.contender)
    }

    /// The line to print when the point is done.
    pub fn progress(&self) -> String {
        match &self.left_out {
            Some(reason) => format!("{}: left out, {reason}", self.label()),
            None => format!(
                "{}: {} ms, camera {}, {} frames of {}, PSNR {}, grids {:?}, {} indices",
                self.label(),
                Time::text(self.stage),
                Time::text(self.camera),
                self.frames,
                Time::text(self.frame),
                figure(self.psnr, 1),
                self.grids,
                self.longest_list
            ),
        }
    }
}

impl LightScaling {
    pub fn join(&mut self, more: Self) {
        self.points.extend(more.points);
    }

    /// Contenders that were measured or left out, in order.
    pub fn contenders(&self) -> Vec<&str> {
        distinct(self.points.iter().map(|p| p.contender.as_str()))
    }

    /// Size, arrangement and number of lights of each picture.
    fn scenes(&self) -> Vec<Vec<String>> {
        distinct(self.points.iter().map(|p| {
            vec![
                size_key(p.size),
                p.arrangement.clone(),
                p.lights.to_string(),
            ]
        }))
    }

    /// Notes below the table.
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for point in &self.points {
            if let Some(reason) = &point.left_out {
                notes.push(format!("{}: not measured, {reason}.", point.label()));
            }
            if point.lists_grew {
                let label = point.label();
                notes.push(format!("{label}: Bevy's lists of lights were too short."));
            }
        }
        notes
    }
}

impl Figures for LightScaling {
    fn device(&self) -> Device {
        self.device.clone()
    }

    fn records(&self) -> Vec<Record> {
        let record = |p: &Point| {
            let is_same = |o: &&Point| {
                (o.size, &o.arrangement, o.lights) == (p.size, &p.arrangement, p.lights)
            };
            let same = || self.points.iter().filter(is_same);
            let peer = same().find(|o| o.contender == PEER).and_then(|o| o.stage);
            let ratio = p
                .stage
                .zip(peer)
                .map(|(own, peer)| own.median / peer.median);
            let [x, y] = p.size;
            let keys = [
                size_key(p.size),
                p.arrangement.clone(),
                p.lights.to_string(),
                p.contender.clone(),
            ];
            let mut record = Record::new(keys, p)
                .with("ratio", ratio)
                .with("size_text", format!("{x}×{y}"))
                .with("longest_list", same().map(|o| o.longest_list).max());
            if p.left_out.is_some() {
                record = record.with("stage", Value::from("not measured"));
            }
            record
        };
        self.points.iter().map(record).collect()
    }

    fn tables(&self) -> Vec<Table> {
        let contenders = self.contenders();
        let Some(first) = contenders.first() else {
            return Vec::new();
        };
        let of_first = |path: &str| format!("{{{first} | {path}}}");
        let mut columns: Vec<(String, String)> = vec![
            ("size".into(), of_first("size_text")),
            ("arrangement".into(), of_first("arrangement")),
            ("lights".into(), of_first("lights")),
        ];
        for contender in &contenders {
            let title = format!("{contender}: {}", stage(contender));
            columns.push((title, format!("{{{contender} | stage :time}}")));
            if contender.starts_with("lean") {
                columns.push(("×".into(), format!("{{{contender} | ratio :.3}}")));
            }
        }
        let cameras = contenders
            .iter()
            .map(|c| format!("{{{c} | camera.median :.2}}"));
        let cameras: Vec<String> = cameras.collect();
        columns.push(("cameras".into(), cameras.join(" / ")));
        for contender in contenders.iter().filter(|c| **c != FORWARD) {
            let cell = format!("{{{contender} | psnr :.1}}");
            columns.push((format!("PSNR, {contender}"), cell));
        }
        columns.push(("indices of lights".into(), of_first("longest_list")));
        let columns: Vec<(&str, &str)> = columns
            .iter()
            .map(|(title, cell)| (title.as_str(), cell.as_str()))
            .collect();
        let mut table = Table::of(&self.records(), &self.scenes(), &columns);
        table.notes = self.notes();
        vec![table]
    }

    fn legend(&self) -> String {
        "Medians (10th–90th percentile) in ms; × is to Bevy deferred; PSNR in dB, against forward"
            .into()
    }

    fn plots(&self) -> Vec<Plot> {
        vec![plot::plot(self)]
    }
}
