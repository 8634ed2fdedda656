//! GPU time, bytes and error of a frame.

use serde::{Deserialize, Serialize};

use super::{Figures, distinct, only};
use crate::{
    numbers::{fixed, percent},
    plots::{Plot, bars::Bars, points::Points},
    table::Table,
    time::{Device, Time},
};

#[derive(Serialize, Deserialize, Clone)]
pub struct Measurement {
    #[serde(flatten)]
    pub device: Device,
    /// Missing in older files.
    #[serde(default)]
    pub size: Option<[u32; 2]>,
    #[serde(default)]
    pub frames: Option<usize>,
    pub scene: String,
    pub contender: String,
    /// Rasterising: the G-buffer, or forward's opaque pass with its lighting.
    pub geometry: Option<Time>,
    pub lighting: Option<Time>,
    /// Bevy's pass of blended meshes. Missing in older files.
    #[serde(default)]
    pub blended: Option<Time>,
    /// Everything from the first to the last pass of the camera, including shadow maps and post-processing.
    pub camera: Option<Time>,
    pub bytes_written_by_geometry: u32,
    pub bytes_in_all: u32,
    /// Against forward; `None` for forward itself, and for equal pictures.
    pub psnr: Option<f64>,
    pub flip: Option<f64>,
    pub off_by_8: Option<f64>,
}

impl Measurement {
    /// PSNR in dB; ∞ for equal pictures.
    pub fn psnr_text(&self) -> String {
        match (self.psnr, self.off_by_8) {
            (None, Some(_)) => "∞".into(),
            (psnr, _) => fixed(psnr, 1),
        }
    }

    /// Bytes a pixel, written by geometry / moved by geometry and lighting.
    pub fn bytes_text(&self) -> String {
        format!("{} / {}", self.bytes_written_by_geometry, self.bytes_in_all)
    }
}

#[derive(Serialize, Deserialize, Default)]
#[serde(transparent)]
pub struct FrameTimes(pub Vec<Measurement>);

/// Left out of plots of errors: light that only exists to be timed, and changes the picture, and contenders that are gone.
const NOT_COMPARED: [&str; 3] = [
    "lean taking indirect light",
    "lean 5-tap normal",
    "lean 3-tap normal",
];

/// The reference of ratios.
const PEER: &str = "Bevy deferred";

const COLUMNS: [&str; 11] = [
    "scene", "renderer", "geometry", "×", "lighting", "×", "camera", "bytes", "PSNR dB", "FLIP",
    "> 8/255",
];

impl FrameTimes {
    pub fn join(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    fn peer(&self, of: &Measurement) -> Option<&Measurement> {
        let is_peer =
            |m: &&Measurement| m.scene == of.scene && m.size == of.size && m.contender == PEER;
        self.0.iter().find(is_peer)
    }

    /// Text for progress output.
    pub fn row(m: &Measurement) -> String {
        let [geometry, lighting, camera] = [m.geometry, m.lighting, m.camera].map(Time::text);
        format!(
            "{}, {}: geometry {geometry}, lighting {lighting}, camera {camera} ms, PSNR {} dB",
            m.scene,
            m.contender,
            fixed(m.psnr, 1)
        )
    }

    #[track_caller]
    pub fn at(&self, scene: &str, contender: &str) -> &Measurement {
        let of_scene = self.of_scene(scene);
        let found = of_scene.filter(|m| m.contender == contender);
        only(found, (scene, contender))
    }

    /// A table of some of its measurements.
    pub fn table<'a>(&'a self, rows: impl IntoIterator<Item = &'a Measurement>) -> Table {
        let row = |m: &Measurement| {
            let peer = self.peer(m);
            let ratio = |of: fn(&Measurement) -> Option<Time>, digits| {
                let ratio = of(m).zip(peer.and_then(of));
                let ratio = ratio.map(|(own, peer)| own.median / peer.median);
                fixed(ratio, digits)
            };
            vec![
                m.scene.clone(),
                m.contender.clone(),
                Time::text(m.geometry),
                ratio(|m| m.geometry, 2),
                Time::text(m.lighting),
                ratio(|m| m.lighting, 3),
                Time::text(m.camera),
                m.bytes_text(),
                m.psnr_text(),
                fixed(m.flip, 4),
                percent(m.off_by_8, 3),
            ]
        };
        Table::new(&COLUMNS, rows.into_iter().map(row))
    }

    fn scenes(&self) -> Vec<&str> {
        distinct(self.0.iter().map(|m| m.scene.as_str()))
    }

    pub fn of_scene(&self, scene: &str) -> impl Iterator<Item = &Measurement> {
        self.0.iter().filter(move |m| m.scene == scene)
    }

    /// Plot of the camera's time over PSNR.
    fn speed(&self, scene: &str) -> Plot {
        let mut points = Points::new(
            "GPU time of the camera (ms)",
            "error against forward: RMS difference (of 255)",
        );
        for m in self.of_scene(scene) {
            if NOT_COMPARED.contains(&m.contender.as_str()) {
                continue;
            }
            // Forward has no error, so it has no place on a logarithmic axis.
            if let (Some(camera), Some(psnr)) = (m.camera, m.psnr) {
                let rms = 255.0 * 10f64.powf(-psnr / 20.0);
                points.add(group(&m.contender), &m.contender, camera.median, rms);
            } else if let (Some(camera), "Bevy forward") = (m.camera, m.contender.as_str()) {
                points.line("Bevy forward, the reference", camera.median);
            }
        }
        points.plot(
            &format!("speed_{scene}"),
            format!("Speed against error of a frame: {scene}"),
        )
    }

    fn stages(&self) -> Plot {
        let mut bars = Bars::new(
            "GPU time (ms)",
            &["geometry", "lighting", "all else of the camera"],
        );
        for m in self.plain() {
            let [Some(geometry), Some(camera)] = [m.geometry, m.camera] else {
                continue;
            };
            let lighting = m.lighting.map_or(0.0, |time| time.median);
            let rest = (camera.median - geometry.median - lighting).max(0.0);
            let parts = vec![geometry.median, lighting, rest];
            bars.add_to(&m.scene, m.contender.clone(), parts);
        }
        bars.plot("stages", "Stages of a frame".into())
    }

    fn bytes(&self) -> Plot {
        let stages = ["written by geometry", "read and written after it"];
        let mut bars = Bars::new("bytes a pixel", &stages);
        let mut shown: Vec<(&str, u32, u32)> = Vec::new();
        for m in &self.0 {
            let (written, all) = (m.bytes_written_by_geometry, m.bytes_in_all);
            // Bevy's bytes are the same in all scenes, and settings of lighting change none.
            let own = match (m.scene.strip_prefix("targets_"), m.contender.as_str()) {
                (None, name) => name,
                (Some(_), "lean") => m.scene.as_str(),
                (Some(_), _) => continue,
            };
            let is_same = |(name, a, b): &(&str, u32, u32)| {
                let both_lean = name.starts_with("lean") && own.starts_with("lean");
                *name == own || both_lean && (*a, *b) == (written, all)
            };
            if !shown.iter().any(is_same) {
                shown.push((own, written, all));
            }
        }
        for (name, written, all) in shown {
            let rest = all.saturating_sub(written);
            bars.add(name.into(), vec![f64::from(written), f64::from(rest)]);
        }
        bars.plot(
            "bytes",
            "Bytes a pixel of a frame, counted from the formats".into(),
        )
    }

    /// Renderers with their defaults, in scenes that compare renderers.
    fn plain(&self) -> impl Iterator<Item = &Measurement> {
        let plain = ["Bevy forward", PEER, "lean"];
        (self.0.iter())
            .filter(move |m| compares_renderers(&m.scene) && plain.contains(&m.contender.as_str()))
    }
}

/// False for scenes that show the cost of one kind of mesh or light.
fn compares_renderers(scene: &str) -> bool {
    !["targets", "glass", "probes"]
        .iter()
        .any(|kind| scene.contains(kind))
}

/// The group of a renderer's points.
fn group(contender: &str) -> &'static str {
    if contender.starts_with("lean") {
        "lean"
    } else {
        "Bevy"
    }
}

impl Figures for FrameTimes {
    fn device(&self) -> Device {
        (self.0.first()).map_or(Device::default(), |m| m.device.clone())
    }

    fn tables(&self) -> Vec<Table> {
        vec![self.table(&self.0)]
    }

    fn legend(&self) -> String {
        let first = self.0.first();
        let size = first
            .and_then(|m| m.size)
            .map(|[x, y]| format!("{x}×{y}, "));
        let frames = first
            .and_then(|m| m.frames)
            .map(|n| format!(" of {n} frames"));
        format!(
            "{}median{} (10th–90th percentile) in ms; × is to Bevy deferred. Bytes a pixel: written by geometry / moved by \
             geometry and lighting. Errors against forward",
            size.unwrap_or_default(),
            frames.unwrap_or_default()
        )
    }

    fn plots(&self) -> Vec<Plot> {
        let compared = |scene: &&str| {
            let others = self.of_scene(scene).filter(|m| m.psnr.is_some());
            compares_renderers(scene) && others.count() > 1
        };
        let speeds = self.scenes().into_iter().filter(compared);
        let mut plots: Vec<Plot> = speeds.map(|scene| self.speed(scene)).collect();
        plots.extend([self.stages(), self.bytes()]);
        plots
    }
}
