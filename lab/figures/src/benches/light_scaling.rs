//! Cost of lighting over the number of lights.

mod plot;

use serde::{Deserialize, Serialize};

use super::{Figures, distinct, only};
use crate::{
    numbers::{beside, fixed, median},
    plots::Plot,
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

/// Size, arrangement and number of lights of a picture.
pub type Scene<'a> = ([u32; 2], &'a str, u32);

impl Point {
    pub fn label(&self) -> String {
        let [width, height] = self.size;
        let (arrangement, lights) = (&self.arrangement, self.lights);
        format!("{width}x{height} {arrangement} {lights} {}", self.contender)
    }

    /// The stage as a cell of the table.
    fn stage_text(&self) -> String {
        match self.left_out {
            Some(_) => "not measured".into(),
            None => Time::text(self.stage),
        }
    }

    fn is_of(&self, scene: Scene) -> bool {
        (self.size, self.arrangement.as_str(), self.lights) == scene
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
                fixed(self.psnr, 1),
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

    fn scenes(&self) -> Vec<Scene<'_>> {
        let scenes = (self.points.iter()).map(|p| (p.size, p.arrangement.as_str(), p.lights));
        distinct(scenes)
    }

    #[track_caller]
    pub fn at(&self, scene: Scene, contender: &str) -> &Point {
        let all = self.points.iter();
        let found = all.filter(|p| p.is_of(scene) && p.contender == contender);
        only(found, (scene, contender))
    }

    pub fn table(&self) -> Table {
        let contenders = self.contenders();
        let mut columns: Vec<String> = ["size", "arrangement", "lights"].map(Into::into).into();
        for contender in &contenders {
            columns.push(format!("{contender}: {}", stage(contender)));
            if contender.starts_with("lean") {
                columns.push("×".into());
            }
        }
        columns.push("cameras".into());
        let others = || contenders.iter().filter(|c| **c != FORWARD);
        columns.extend(others().map(|contender| format!("PSNR, {contender}")));
        columns.push("indices of lights".into());
        let row = |scene: Scene| {
            let points = || self.points.iter().filter(|p| p.is_of(scene));
            let of = |contender: &str| points().find(|p| p.contender == contender);
            let ([x, y], arrangement, lights) = scene;
            let mut row = vec![
                format!("{x}×{y}"),
                arrangement.to_owned(),
                lights.to_string(),
            ];
            let median_of = |contender| of(contender).and_then(|p| Some(p.stage?.median));
            for contender in &contenders {
                row.push(of(contender).map_or(fixed(None, 0), Point::stage_text));
                if contender.starts_with("lean") {
                    let ratio = median_of(contender).zip(median_of(PEER));
                    row.push(fixed(ratio.map(|(own, peer)| own / peer), 3));
                }
            }
            let camera = |contender: &&str| median(of(contender).and_then(|p| p.camera), 2);
            row.push(beside(contenders.iter().map(camera)));
            row.extend(others().map(|c| fixed(of(c).and_then(|p| p.psnr), 1)));
            let longest = points().map(|p| p.longest_list).max();
            row.push(longest.unwrap_or(0).to_string());
            row
        };
        Table {
            columns,
            rows: self.scenes().into_iter().map(row).collect(),
            notes: self.notes(),
            ..Table::default()
        }
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

    fn tables(&self) -> Vec<Table> {
        vec![self.table()]
    }

    fn legend(&self) -> String {
        "Medians (10th–90th percentile) in ms; × is to Bevy deferred; PSNR in dB, against forward"
            .into()
    }

    fn plots(&self) -> Vec<Plot> {
        vec![plot::plot(self)]
    }
}
