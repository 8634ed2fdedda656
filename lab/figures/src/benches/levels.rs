//! Frames of levels: GPU time, bytes, error, memory, and meshes that forward draws.

use serde::{Deserialize, Serialize};

use super::{Figures, distinct};
use crate::{
    numbers::{fixed, percent},
    plots::{Plot, bars::Bars},
    table::Table,
    time::{Device, Time},
};

/// Meshes that Bevy's forward passes draw on a lean camera.
#[derive(Serialize, Deserialize, Clone, Debug)]
pub struct ForwardMeshes {
    pub reason: String,
    pub meshes: usize,
    /// Names of some of their materials.
    pub materials: Vec<String>,
}

#[derive(Serialize, Deserialize, Clone)]
pub struct Measurement {
    #[serde(flatten)]
    pub device: Device,
    pub size: [u32; 2],
    pub frames: usize,
    pub level: String,
    /// Its number in the level's list.
    pub view: usize,
    pub contender: String,
    /// Meshes in view.
    pub meshes: usize,
    /// Point and spot lights of the whole level.
    pub lights: usize,
    /// Meshes of the whole level with a lightmap.
    pub lightmapped: usize,
    /// Rasterising: the G-buffer, or forward's opaque pass with its lighting.
    pub geometry: Option<Time>,
    /// Invocations of fragment shaders in `geometry`, per pixel of the picture; `None` where the device does not count them.
    #[serde(default)]
    pub fragments: Option<f64>,
    pub lighting: Option<Time>,
    /// All passes of effects.
    pub effects: Option<Time>,
    /// Bevy's pass of blended meshes.
    pub blended: Option<Time>,
    /// Everything from the first to the last pass of the camera, including shadow maps and post-processing.
    pub camera: Option<Time>,
    /// Names and medians of all spans, in milliseconds.
    pub spans: Vec<(String, f64)>,
    /// Without effects.
    pub bytes_written_by_geometry: u32,
    pub bytes_in_all: u32,
    /// Against forward; `None` for forward itself, for equal pictures, and with effects, which change the picture.
    pub psnr: Option<f64>,
    /// `None` for forward itself, and with effects.
    pub off_by_8: Option<f64>,
    /// The worst PSNR of a walk's frames, as `psnr`; `None` without a walk.
    #[serde(default)]
    pub walk_psnr: Option<f64>,
    /// Bytes of GPU memory by field of `LeanMemory`. Empty for renderers of Bevy.
    pub memory: Vec<(String, u64)>,
    /// The most meshes first. Empty for renderers of Bevy.
    pub forward: Vec<ForwardMeshes>,
}

impl Measurement {
    /// PSNR in dB; ∞ for equal pictures.
    fn psnr_text(&self) -> String {
        match (self.psnr, self.off_by_8) {
            (None, Some(_)) => "∞".into(),
            (psnr, _) => fixed(psnr, 1),
        }
    }

    fn is_lean(&self) -> bool {
        !self.memory.is_empty()
    }

    fn place(&self) -> (&str, usize, [u32; 2]) {
        (&self.level, self.view, self.size)
    }

    /// First cells of its row in any table.
    fn row_head(&self) -> Vec<String> {
        vec![
            self.level.clone(),
            self.view.to_string(),
            self.contender.clone(),
        ]
    }
}

#[derive(Serialize, Deserialize, Default)]
#[serde(transparent)]
pub struct Levels(pub Vec<Measurement>);

/// The reference of ratios and errors.
const REFERENCE: &str = "Bevy forward";

const COLUMNS: [&str; 12] = [
    "level", "view", "renderer", "geometry", "lighting", "effects", "blended", "camera", "×",
    "bytes", "PSNR dB", "> 8/255",
];

impl Levels {
    pub fn join(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    /// Text for progress output.
    pub fn row(m: &Measurement) -> String {
        let [geometry, lighting, blended, camera] =
            [m.geometry, m.lighting, m.blended, m.camera].map(Time::text);
        format!(
            "{}, view {}, {}: geometry {geometry}, lighting {lighting}, blended {blended}, camera {camera} ms, PSNR {} dB, in a walk {} dB",
            m.level,
            m.view,
            m.contender,
            m.psnr_text(),
            fixed(m.walk_psnr, 1)
        )
    }

    /// GPU times as medians, bytes and errors.
    pub fn table(&self) -> Table {
        let row = |m: &Measurement| {
            let camera = m.camera.zip(self.at(m, REFERENCE).and_then(|m| m.camera));
            let ratio = camera.map(|(own, forward)| own.median / forward.median);
            let times = [m.geometry, m.lighting, m.effects, m.blended, m.camera];
            let mut row = m.row_head();
            row.extend(times.map(|time| fixed(time.map(|time| time.median), 3)));
            row.extend([
                fixed(ratio, 2),
                format!("{} / {}", m.bytes_written_by_geometry, m.bytes_in_all),
                m.psnr_text(),
                percent(m.off_by_8, 3),
            ]);
            row
        };
        Table::new(&COLUMNS, self.0.iter().map(row))
    }

    /// Errors of each view against forward, and the meshes that lean cameras leave to forward.
    pub fn views(&self) -> Table {
        let columns = [
            "level",
            "view",
            "lights",
            "lightmapped",
            "Bevy deferred, dB",
            "lean, dB",
            "meshes",
            "drawn forward",
        ];
        let row = |m: &Measurement| {
            let bevy = self.at(m, "Bevy deferred");
            let forward = m.forward.iter();
            let forward: Vec<String> = forward
                .map(|forward| format!("{} {}", forward.meshes, forward.reason))
                .collect();
            vec![
                m.level.clone(),
                m.view.to_string(),
                m.lights.to_string(),
                m.lightmapped.to_string(),
                bevy.map_or_else(|| fixed(None, 1), Measurement::psnr_text),
                m.psnr_text(),
                m.meshes.to_string(),
                forward.join(", "),
            ]
        };
        let lean = self.0.iter().filter(|m| m.contender == "lean");
        Table::new(&columns, lean.map(row))
    }

    /// Times of the whole camera by renderer, a row per view.
    pub fn cameras(&self, size: [u32; 2]) -> Table {
        let columns = [
            "level",
            "view",
            "lights",
            "Bevy forward",
            "with depth prepass",
            "Bevy deferred",
            "lean",
            "× forward",
            "with effects",
            "bytes",
            "Bevy deferred, dB",
            "lean, dB",
        ];
        let row = |m: &Measurement| {
            let other = |contender: &str| self.at(m, contender);
            let time = |of: Option<&Measurement>| of.and_then(|m| m.camera).map(|t| t.median);
            let forward = time(other(REFERENCE));
            let ratio = time(Some(m)).zip(forward).map(|(own, theirs)| own / theirs);
            vec![
                m.level.clone(),
                m.view.to_string(),
                m.lights.to_string(),
                fixed(forward, 1),
                fixed(time(other("Bevy forward with prepass")), 1),
                fixed(time(other("Bevy deferred")), 1),
                fixed(time(Some(m)), 1),
                fixed(ratio, 2),
                fixed(time(other("lean with effects")), 1),
                format!("{} / {}", m.bytes_written_by_geometry, m.bytes_in_all),
                other("Bevy deferred").map_or_else(|| fixed(None, 1), Measurement::psnr_text),
                m.psnr_text(),
            ]
        };
        let lean = self
            .0
            .iter()
            .filter(|m| m.contender == "lean" && m.size == size);
        Table::new(&columns, lean.map(row))
    }

    /// The G-buffer with alpha-masked meshes drawn once, and depth first. Views without any are left out.
    pub fn masks(&self) -> Table {
        let columns = [
            "size",
            "level",
            "view",
            "once: fragments per pixel",
            "depth first",
            "once: ms",
            "depth first",
            "×",
        ];
        let row = |m: &Measurement| {
            let once = self.at(m, "lean without depth of masks")?;
            let [width, height] = m.size;
            let median = |m: &Measurement| m.geometry.map(|time| time.median);
            let ratio = median(m).zip(median(once)).map(|(own, once)| own / once);
            let is_masked = m.fragments != once.fragments;
            is_masked.then(|| {
                vec![
                    format!("{width}×{height}"),
                    m.level.clone(),
                    m.view.to_string(),
                    fixed(once.fragments, 2),
                    fixed(m.fragments, 2),
                    fixed(median(once), 2),
                    fixed(median(m), 2),
                    fixed(ratio, 2),
                ]
            })
        };
        let lean = self.0.iter().filter(|m| m.contender == "lean");
        Table::new(&columns, lean.filter_map(row))
    }

    /// The measurement of `contender` in the place of `m`.
    fn at(&self, m: &Measurement, contender: &str) -> Option<&Measurement> {
        let mut all = self.0.iter();
        all.find(|other| other.place() == m.place() && other.contender == contender)
    }

    fn lean(&self) -> impl Iterator<Item = &Measurement> {
        self.0.iter().filter(|m| m.is_lean())
    }

    /// MiB by effect, without those that no camera has.
    pub fn memory(&self) -> Table {
        let held = self.lean().flat_map(|m| &m.memory);
        let fields = distinct(
            held.filter(|(_, bytes)| *bytes > 0)
                .map(|(field, _)| field.as_str()),
        );
        let mib = |bytes: u64| fixed(bytes as f64 / f64::from(1 << 20), 1);
        let row = |m: &Measurement| {
            let bytes_of = |field: &str| {
                let found = m.memory.iter().find(|(name, _)| name == field);
                found.map_or(0, |(_, bytes)| *bytes)
            };
            let mut row = m.row_head();
            row.extend(fields.iter().map(|field| mib(bytes_of(field))));
            row.push(mib(m.memory.iter().map(|(_, bytes)| bytes).sum()));
            row
        };
        let names = fields.iter().map(|field| field.replace('_', " "));
        let columns: Vec<String> = ["level", "view", "renderer"]
            .map(String::from)
            .into_iter()
            .chain(names)
            .chain(["all".into()])
            .collect();
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        Table::new(&columns, self.lean().map(row))
    }

    /// Meshes in view, and a row for each reason for which forward draws some of them.
    pub fn forward(&self) -> Table {
        let columns = [
            "level",
            "view",
            "renderer",
            "meshes",
            "drawn forward",
            "reason",
            "materials",
        ];
        let rows = self.lean().flat_map(|m| {
            m.forward.iter().map(|forward| {
                let mut row = m.row_head();
                row.extend([
                    m.meshes.to_string(),
                    forward.meshes.to_string(),
                    forward.reason.clone(),
                    forward.materials.join(", "),
                ]);
                row
            })
        });
        Table::new(&columns, rows)
    }

    fn stages(&self) -> Plot {
        let stages = [
            "geometry",
            "lighting",
            "effects",
            "blended",
            "all else of the camera",
        ];
        let mut bars = Bars::new("GPU time (ms)", &stages);
        for m in &self.0 {
            let Some(camera) = m.camera else {
                continue;
            };
            let times = [m.geometry, m.lighting, m.effects, m.blended];
            let mut parts: Vec<f64> = times.map(|t| t.map_or(0.0, |t| t.median)).into();
            parts.push((camera.median - parts.iter().sum::<f64>()).max(0.0));
            let place = format!("{}, view {}", m.level, m.view);
            bars.add_to(&place, m.contender.clone(), parts);
        }
        bars.plot("levels", "Stages of a frame".into())
    }
}

impl Figures for Levels {
    fn device(&self) -> Device {
        (self.0.first()).map_or(Device::default(), |m| m.device.clone())
    }

    fn tables(&self) -> Vec<Table> {
        vec![
            self.table().titled("**Frames**"),
            self.memory().titled("**GPU memory in MiB**"),
            self.forward().titled("**Meshes drawn forward**"),
        ]
    }

    fn legend(&self) -> String {
        let about = self.0.first().map(|m| {
            let [x, y] = m.size;
            format!("{x}×{y}, medians of {} frames in ms. ", m.frames)
        });
        format!(
            "{}× is the camera's time to Bevy forward's. Bytes per pixel without effects: written by geometry / moved by geometry and \
             lighting. Errors against forward",
            about.unwrap_or_default()
        )
    }

    fn plots(&self) -> Vec<Plot> {
        match self.0.iter().any(|m| m.camera.is_some()) {
            true => vec![self.stages()],
            false => Vec::new(),
        }
    }
}
