//! The figures, and the Markdown table.

use core::fmt::Write;

use bevy::math::UVec2;
use kit::{figures::figure, gpu_time::Time};
use serde::{Deserialize, Serialize};

use crate::{contender::Contender, scene::Arrangement};

/// All that was measured.
#[derive(Serialize, Deserialize, Default)]
pub struct Report {
    pub adapter: String,
    pub points: Vec<Point>,
}

/// One renderer with one number of lights.
#[derive(Serialize, Deserialize)]
pub struct Point {
    pub size: [u32; 2],
    pub arrangement: String,
    pub lights: u32,
    pub contender: String,
    /// Why it was not measured.
    pub left_out: Option<String>,
    pub frames: usize,
    /// Lighting; of forward, the opaque pass with its lighting.
    pub stage: Option<Time>,
    /// Everything from the first to the last pass of the camera.
    pub camera: Option<Time>,
    /// The whole frame, from the start of its systems to the end of GPU work, by the clock of the CPU.
    pub frame: Option<Time>,
    /// Against forward, in dB; none for forward itself, where that was not measured, and for equal pictures.
    pub psnr: Option<f64>,
    /// Bevy's clusters in the measured frames: each grid that was used, and the most indices of lights in all clusters.
    pub grids: Vec<[u32; 3]>,
    pub longest_list: usize,
    /// Whether Bevy found its lists too short in a measured frame.
    pub lists_grew: bool,
}

impl Point {
    pub fn new(contender: Contender, size: UVec2, arrangement: Arrangement, lights: u32) -> Self {
        Self {
            size: size.to_array(),
            arrangement: arrangement.name().into(),
            lights,
            contender: contender.name().into(),
            left_out: None,
            frames: 0,
            stage: None,
            camera: None,
            frame: None,
            psnr: None,
            grids: Vec::new(),
            longest_list: 0,
            lists_grew: false,
        }
    }

    pub fn label(&self) -> String {
        let [width, height] = self.size;
        let (arrangement, lights) = (&self.arrangement, self.lights);
        format!("{width}x{height} {arrangement} {lights} {}", self.contender)
    }

    /// What is said when it is done.
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

impl Report {
    /// Those that were measured or left out, in the usual order.
    pub fn contenders(&self) -> Vec<Contender> {
        let mut contenders = Contender::ALL.to_vec();
        contenders.retain(|c| self.points.iter().any(|p| p.contender == c.name()));
        contenders
    }

    /// Each picture that was rendered, by size, arrangement and number of lights.
    pub fn scenes(&self) -> Vec<([u32; 2], &str, u32)> {
        let mut scenes = Vec::new();
        for point in &self.points {
            let scene = (point.size, point.arrangement.as_str(), point.lights);
            if !scenes.contains(&scene) {
                scenes.push(scene);
            }
        }
        scenes
    }

    pub fn point(&self, scene: ([u32; 2], &str, u32), contender: Contender) -> Option<&Point> {
        self.points.iter().find(|p| {
            (p.size, p.arrangement.as_str(), p.lights) == scene && p.contender == contender.name()
        })
    }

    /// One row for each number of lights.
    pub fn markdown(&self) -> String {
        let contenders = self.contenders();
        let mut text = format!(
            "{}, medians (10th–90th percentile) in ms; × is to Bevy deferred; PSNR in dB, against forward.\n\n\
             | size | arrangement | lights |",
            self.adapter
        );
        for contender in &contenders {
            let _ = write!(text, " {}: {} |", contender.name(), contender.stage());
            if contender.is_lean() {
                text.push_str(" × |");
            }
        }
        text.push_str(" cameras |");
        for contender in contenders.iter().skip_while(|c| **c == Contender::Forward) {
            let _ = write!(text, " PSNR, {} |", contender.name());
        }
        text.push_str(" indices of lights |\n");
        let columns = text
            .lines()
            .last()
            .map_or(0, |line| line.matches('|').count() - 1);
        let _ = writeln!(text, "|{}", "---|".repeat(columns));
        for scene in self.scenes() {
            text.push_str(&self.row(scene, &contenders));
        }
        text.push_str(&self.notes());
        text
    }

    fn row(&self, scene: ([u32; 2], &str, u32), contenders: &[Contender]) -> String {
        let ([width, height], arrangement, lights) = scene;
        let mut row = format!("| {width}×{height} | {arrangement} | {lights} |");
        let stage = |contender| self.point(scene, contender).and_then(|p| p.stage);
        for contender in contenders {
            let left_out = self
                .point(scene, *contender)
                .is_some_and(|p| p.left_out.is_some());
            let time = match left_out {
                true => "not measured".into(),
                false => Time::text(stage(*contender)),
            };
            let _ = write!(row, " {time} |");
            if contender.is_lean() {
                let ratio = match (stage(*contender), stage(Contender::BevyDeferred)) {
                    (Some(time), Some(peer)) => Some(time.median / peer.median),
                    _ => None,
                };
                let _ = write!(row, " {} |", figure(ratio, 3));
            }
        }
        let cameras = contenders.iter().map(|contender| {
            let camera = self.point(scene, *contender).and_then(|p| p.camera);
            figure(camera.map(|time| time.median), 2)
        });
        let _ = write!(row, " {} |", cameras.collect::<Vec<_>>().join(" / "));
        for contender in contenders.iter().skip_while(|c| **c == Contender::Forward) {
            let psnr = self.point(scene, *contender).and_then(|p| p.psnr);
            let _ = write!(row, " {} |", figure(psnr, 1));
        }
        let points = contenders.iter().filter_map(|c| self.point(scene, *c));
        let longest = points.map(|p| p.longest_list).max().unwrap_or(0);
        let _ = writeln!(row, " {longest} |");
        row
    }

    /// What the table cannot say.
    fn notes(&self) -> String {
        let mut notes = String::new();
        for point in &self.points {
            if let Some(reason) = &point.left_out {
                let _ = writeln!(notes, "- {}: not measured, {reason}.", point.label());
            }
            if point.lists_grew {
                let label = point.label();
                let _ = writeln!(notes, "- {label}: Bevy's lists of lights were too short.");
            }
        }
        if !notes.is_empty() {
            notes.insert(0, '\n');
        }
        notes
    }
}
