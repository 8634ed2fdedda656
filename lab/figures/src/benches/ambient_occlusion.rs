//! GPU time, bytes and error of ambient occlusion.

use serde::{Deserialize, Serialize};

use super::{Figures, distinct, only};
use crate::{
    numbers::{fixed, rmse_and_bias},
    plots::{Plot, bars::Bars, points::Points},
    table::Table,
    time::{Device, Time},
};

#[derive(Serialize, Deserialize, Clone)]
pub struct Measurement {
    #[serde(flatten)]
    pub device: Device,
    #[serde(default)]
    pub frames: Option<usize>,
    pub size: [u32; 2],
    pub contender: String,
    pub lean: bool,
    /// Times of the passes that only occlusion has, in order.
    pub passes: Vec<Time>,
    /// Time of the lighting pass, which filters and applies occlusion on lean cameras.
    pub lighting: Option<Time>,
    /// Time of prepasses, which Bevy's occlusion needs.
    pub prepass: Option<Time>,
    pub camera: Option<Time>,
    pub bytes: Bytes,
    /// Share of pixels with occlusion.
    pub occluded: f64,
    /// Root mean square error and bias, against the closed form of the wall.
    pub wall: Option<(f64, f64)>,
    /// Mean occlusion of the plane, where the truth is 0.
    pub plane: Option<f64>,
}

impl Measurement {
    /// Time of its own passes.
    pub fn own(&self) -> f64 {
        self.passes.iter().map(|time| time.median).sum()
    }

    pub fn megabytes(&self) -> f64 {
        let pixels = f64::from(self.size[0]) * f64::from(self.size[1]);
        self.bytes.compulsory * pixels / 1e6
    }
}

/// Bytes per pixel, without and with the reads of depth and normals.
#[derive(Serialize, Deserialize, Clone, Copy)]
pub struct Bytes {
    /// Each texture once written and once read.
    pub compulsory: f64,
    pub compulsory_with_depth: f64,
    /// Every texel of every fetch and gather.
    pub fetched: f64,
}

#[derive(Serialize, Deserialize, Default)]
#[serde(transparent)]
pub struct AmbientOcclusion(pub Vec<Measurement>);

const COLUMNS: [&str; 10] = [
    "contender",
    "gather",
    "merge",
    "lighting",
    "prepass",
    "all",
    "bytes",
    "MB",
    "wall",
    "plane",
];

impl AmbientOcclusion {
    pub fn join(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    #[track_caller]
    pub fn at(&self, size: [u32; 2], contender: &str) -> &Measurement {
        let all = self.0.iter();
        let found = all.filter(|m| m.size == size && m.contender == contender);
        only(found, (size, contender))
    }

    /// Additional time of `of`, over the same camera without occlusion.
    fn more(&self, m: &Measurement, of: fn(&Measurement) -> Option<Time>) -> Option<f64> {
        let is_without =
            |o: &&Measurement| o.size == m.size && o.lean == m.lean && o.passes.is_empty();
        let without = self.0.iter().find(is_without)?;
        Some(of(m)?.median - of(without).map_or(0.0, |time| time.median))
    }

    pub fn more_lighting(&self, m: &Measurement) -> Option<f64> {
        self.more(m, |m| m.lighting)
    }

    /// Additional time of the prepass, for contenders that need one: for others the difference is noise.
    pub fn more_prepass(&self, m: &Measurement) -> Option<f64> {
        let needs_one = group(m) == "Bevy" || group(m) == "naive";
        self.more(m, |m| m.prepass).filter(|_| needs_one)
    }

    pub fn all(&self, m: &Measurement) -> f64 {
        let lighting = self.more_lighting(m).unwrap_or(0.0);
        m.own() + lighting + self.more_prepass(m).unwrap_or(0.0)
    }

    /// Cells from additional time of lighting to the mean of the plane.
    pub fn costs(&self, m: &Measurement) -> Vec<String> {
        let bytes = m.bytes;
        vec![
            fixed(self.more_lighting(m), 3),
            fixed(self.more_prepass(m), 3),
            fixed(self.all(m), 3),
            format!(
                "{:.1} / {:.1} / {:.0}",
                bytes.compulsory, bytes.compulsory_with_depth, bytes.fetched
            ),
            fixed(m.megabytes(), 1),
            rmse_and_bias(m.wall),
            fixed(m.plane, 4),
        ]
    }

    fn sizes(&self) -> Vec<[u32; 2]> {
        let mut sizes = distinct(self.0.iter().map(|m| m.size));
        sizes.sort_unstable();
        sizes
    }

    /// Contenders with occlusion, at the largest size.
    fn shown(&self) -> impl Iterator<Item = &Measurement> {
        let largest = self.sizes().last().copied();
        let is_shown = move |m: &&Measurement| Some(m.size) == largest && !m.passes.is_empty();
        self.0.iter().filter(is_shown)
    }

    fn size_text(&self) -> String {
        (self.sizes().last()).map_or(String::new(), |[x, y]| format!(", {x}×{y}"))
    }

    fn speed(&self) -> Plot {
        let mut points = Points::new(
            "GPU time with all that it needs (ms)",
            "RMSE of occlusion before a tall wall",
        );
        for m in self.shown() {
            if let Some((rmse, _)) = m.wall {
                points.add(group(m), &short(m), self.all(m), rmse);
            }
        }
        let title = format!(
            "Speed against error of ambient occlusion{}",
            self.size_text()
        );
        points.plot("speed", title)
    }

    fn stages(&self) -> Plot {
        let mut bars = Bars::new("GPU time (ms)", &["gather", "merge", "lighting", "prepass"]);
        for m in self.shown() {
            let pass = |index: usize| m.passes.get(index).map_or(0.0, |time| time.median);
            let [lighting, prepass] = [
                self.more_lighting(m).unwrap_or(0.0),
                self.more_prepass(m).unwrap_or(0.0),
            ];
            let parts = vec![pass(0), pass(1), lighting.max(0.0), prepass.max(0.0)];
            bars.add(m.contender.clone(), parts);
        }
        let title = format!("Stages of ambient occlusion{}", self.size_text());
        bars.plot("stages", title)
    }

    fn bytes(&self) -> Plot {
        let stages = ["of its own textures", "depth and normals"];
        let mut bars = Bars::new(
            "bytes a pixel, each texture once written and once read",
            &stages,
        );
        for m in self.shown() {
            let Bytes {
                compulsory,
                compulsory_with_depth,
                ..
            } = m.bytes;
            bars.add(
                m.contender.clone(),
                vec![compulsory, compulsory_with_depth - compulsory],
            );
        }
        bars.plot("bytes", "Bytes a pixel of ambient occlusion".into())
    }
}

fn group(m: &Measurement) -> &'static str {
    if m.contender.starts_with("Bevy") {
        "Bevy"
    } else if m.contender == "naive" {
        "naive"
    } else if m.lean {
        "lean, indirect"
    } else {
        "lean, blend on forward"
    }
}

/// The name, without the part that its group implies.
fn short(m: &Measurement) -> String {
    let name = m.contender.replace(", indirect", "").replace(", blend", "");
    name.trim_start_matches("Bevy ").into()
}

impl Figures for AmbientOcclusion {
    fn device(&self) -> Device {
        (self.0.first()).map_or(Device::default(), |m| m.device.clone())
    }

    fn tables(&self) -> Vec<Table> {
        let row = |m: &Measurement| {
            let [gather, merge] = [0, 1].map(|pass| Time::text(m.passes.get(pass).copied()));
            [vec![m.contender.clone(), gather, merge], self.costs(m)].concat()
        };
        let table = |size: [u32; 2]| {
            let rows = self.0.iter().filter(|m| m.size == size).map(row);
            let [x, y] = size;
            Table::new(&COLUMNS, rows).titled(format!("**{x}×{y}**"))
        };
        self.sizes().into_iter().map(table).collect()
    }

    fn legend(&self) -> String {
        let frames = self.0.first().and_then(|m| m.frames);
        format!(
            "Median{} (10th–90th percentile) in ms. Lighting: what the lighting pass takes more than without occlusion. \
             Prepass: what Bevy's needs, more than without. Bytes a pixel: each texture once written and once read without \
             depth and normals / with them / each fetch counted; MB a frame of the first. Wall: RMSE (bias) against the \
             closed form, radius 0.5 m; plane: mean where there is no occlusion",
            frames.map_or(String::new(), |n| format!(" of {n} frames"))
        )
    }

    fn plots(&self) -> Vec<Plot> {
        vec![self.speed(), self.stages(), self.bytes()]
    }
}
