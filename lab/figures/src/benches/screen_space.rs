//! GPU time, bytes and error of screen-space lighting effects.

use serde::{Deserialize, Serialize};

use super::{Figures, distinct, only};
use crate::{
    numbers::{fixed, median, rmse_and_bias, sum_text},
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
    /// Times of the passes that only the effect has, in order.
    pub passes: Vec<Time>,
    /// Times of their dispatches, timed one by one: longer in sum. Empty if each pass has one dispatch.
    #[serde(default)]
    pub stages: Vec<Time>,
    pub lighting: Option<Time>,
    pub camera: Option<Time>,
    pub bytes: f64,
    pub errors: Vec<KnownError>,
}

impl Measurement {
    /// Medians of its stages, or of its passes if it has no stages.
    fn parts(&self) -> Vec<f64> {
        let times = if self.stages.is_empty() {
            &self.passes
        } else {
            &self.stages
        };
        times.iter().map(|time| time.median).collect()
    }

    pub fn parts_text(&self) -> String {
        sum_text(&self.parts(), 3)
    }

    /// Time of its passes, together.
    pub fn own(&self) -> f64 {
        self.passes.iter().map(|time| time.median).sum()
    }

    /// Error of a scene; `None` if the effect has no such scene.
    pub fn error(&self, scene: &str) -> Option<(f64, f64)> {
        let error = self.errors.iter().find(|error| error.scene == scene)?;
        Some((error.rmse.into(), error.bias.into()))
    }

    pub fn error_text(&self, scene: &str) -> String {
        rmse_and_bias(self.error(scene))
    }
}

/// Root mean square and mean of the error of a scene with known light.
#[derive(Serialize, Deserialize, Clone)]
pub struct KnownError {
    pub scene: String,
    pub rmse: f32,
    pub bias: f32,
}

#[derive(Serialize, Deserialize, Default)]
#[serde(transparent)]
pub struct ScreenSpace(pub Vec<Measurement>);

/// The kind of an effect.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Kind {
    DiffuseLight,
    Reflections,
    Scattering,
}

impl Kind {
    const ALL: [Self; 3] = [Self::DiffuseLight, Self::Reflections, Self::Scattering];

    /// The kind of the table that a contender belongs to; `None`: to all.
    fn of(contender: &str) -> Option<Self> {
        if contender == "none" {
            None
        } else if contender.contains("reflections") {
            Some(Self::Reflections)
        } else if contender.starts_with("scattering") {
            Some(Self::Scattering)
        } else {
            Some(Self::DiffuseLight)
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::DiffuseLight => "gi",
            Self::Reflections => "reflections",
            Self::Scattering => "scattering",
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::DiffuseLight => "diffuse GI",
            Self::Reflections => "reflections",
            Self::Scattering => "scattering",
        }
    }

    /// Scenes whose errors a plot shows, and their descriptions.
    fn shown_errors(self) -> &'static [(&'static str, &'static str, &'static str)] {
        match self {
            Self::DiffuseLight => &[(
                "sphere",
                "",
                "RMSE of light on a floor beside a glowing sphere (of πL)",
            )],
            Self::Reflections => &[
                (
                    "inside",
                    "_in_a_mirror",
                    "RMSE in a mirror, without outlines (of 1)",
                ),
                (
                    "0.3",
                    "_on_a_rough_floor",
                    "RMSE on a floor of roughness 0.3 (of the light)",
                ),
            ],
            Self::Scattering => &[(
                "skin, red",
                "",
                "RMSE beside an edge of light, skin, red (of 1)",
            )],
        }
    }

    /// Names of the parts of its time.
    fn passes(self) -> &'static [&'static str] {
        match self {
            Self::DiffuseLight => &["levels", "gather", "filter", "lighting"],
            Self::Reflections => &[
                "history",
                "hi-z",
                "trace",
                "spatial filter",
                "resolve",
                "lighting",
            ],
            Self::Scattering => &["scattering", "lighting"],
        }
    }
}

impl ScreenSpace {
    pub fn join(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    #[track_caller]
    pub fn at(&self, size: [u32; 2], contender: &str) -> &Measurement {
        let all = self.0.iter();
        let found = all.filter(|m| m.size == size && m.contender == contender);
        only(found, (size, contender))
    }

    /// Additional time of lighting, over the camera without effects.
    pub fn more_lighting(&self, m: &Measurement) -> Option<f64> {
        let is_plain = |o: &&Measurement| o.size == m.size && o.contender == "none";
        let plain = self.0.iter().find(is_plain)?.lighting?;
        Some(m.lighting?.median - plain.median)
    }

    pub fn all(&self, m: &Measurement) -> f64 {
        m.own() + self.more_lighting(m).unwrap_or(0.0)
    }

    fn sizes(&self) -> Vec<[u32; 2]> {
        let mut sizes = distinct(self.0.iter().map(|m| m.size));
        sizes.sort_unstable();
        sizes
    }

    /// Measurements of a kind, at the largest size.
    fn of_kind(&self, kind: Kind) -> impl Iterator<Item = &Measurement> {
        let largest = self.sizes().last().copied();
        (self.0.iter()).filter(move |m| {
            Some(m.size) == largest && Kind::of(&m.contender) == Some(kind) && !m.passes.is_empty()
        })
    }

    fn size_text(&self) -> String {
        (self.sizes().last()).map_or(String::new(), |[x, y]| format!(", {x}×{y}"))
    }

    fn speeds(&self, kind: Kind) -> Vec<Plot> {
        let plot = |(scene, suffix, what): &(&str, &str, &str)| {
            let mut points = Points::new("GPU time with all that it needs (ms)", what);
            for m in self.of_kind(kind) {
                if let Some((rmse, _)) = m.error(scene) {
                    let (group, name) = label(&m.contender);
                    points.add(group, &name, self.all(m), rmse);
                }
            }
            let (kind_title, place) = (kind.title(), suffix.replace('_', " "));
            let size = self.size_text();
            let title = format!("Speed against error of {kind_title}{place}{size}");
            points.plot(&format!("speed_{}{suffix}", kind.name()), title)
        };
        kind.shown_errors().iter().map(plot).collect()
    }

    fn stages(&self, kind: Kind) -> Plot {
        let passes = kind.passes();
        let mut bars = Bars::new("GPU time (ms)", passes);
        for m in self.of_kind(kind) {
            let mut parts = m.parts();
            // Bevy's single pass does the work of four.
            if kind == Kind::Reflections && parts.len() == 1 {
                parts = vec![0.0, 0.0, parts[0]];
            }
            // Occlusion only gathers.
            if kind == Kind::DiffuseLight && parts.len() == 1 {
                parts = vec![0.0, parts[0]];
            }
            parts.resize(passes.len() - 1, 0.0);
            parts.push(self.more_lighting(m).unwrap_or(0.0).max(0.0));
            bars.add(m.contender.clone(), parts);
        }
        let title = format!("Stages of {}{}", kind.title(), self.size_text());
        bars.plot(&format!("stages_{}", kind.name()), title)
    }

    fn bytes(&self) -> Plot {
        let mut bars = Bars::new(
            "bytes a pixel, each texture once written and once read, without depth and normals",
            &["bytes"],
        );
        for m in Kind::ALL.into_iter().flat_map(|kind| self.of_kind(kind)) {
            bars.add(m.contender.clone(), vec![m.bytes]);
        }
        bars.plot(
            "bytes",
            "Bytes a pixel of effects that find light on the screen".into(),
        )
    }

    fn table(&self, size: [u32; 2], kind: Kind) -> Table {
        let of_table = |m: &&Measurement| {
            m.size == size && Kind::of(&m.contender).is_none_or(|other| other == kind)
        };
        let shown = || self.0.iter().filter(of_table);
        let with_errors = shown().find(|m| !m.errors.is_empty());
        let scenes: Vec<&str> = with_errors.map_or(Vec::new(), |m| {
            m.errors.iter().map(|error| error.scene.as_str()).collect()
        });
        let row = |m: &Measurement| {
            let mut row = vec![
                m.contender.clone(),
                m.parts_text(),
                fixed(self.more_lighting(m), 3),
                fixed(self.all(m), 3),
                median(m.camera, 3),
                fixed(m.bytes, 1),
            ];
            row.extend(scenes.iter().map(|scene| m.error_text(scene)));
            row
        };
        let mut columns = vec!["contender", "stages", "lighting", "all", "camera", "bytes"];
        columns.extend(&scenes);
        let [x, y] = size;
        let title = format!("**{x}×{y}**, {}", kind.title());
        Table::new(&columns, shown().map(row)).titled(title)
    }
}

/// Group and name of a point.
fn label(contender: &str) -> (&'static str, String) {
    match contender.split_once(", ") {
        _ if contender == "Bevy's reflections" => ("Bevy", "Bevy's".into()),
        _ if contender.starts_with("ambient") => ("lean, occlusion alone", "Medium".into()),
        Some((_, rest)) if rest.ends_with(", Half") => {
            ("lean, half resolution", rest.replace(", Half", ""))
        }
        Some((_, rest)) if rest.ends_with(", Full") => {
            ("lean, full resolution", rest.replace(", Full", ""))
        }
        Some((_, rest)) => ("lean", rest.into()),
        None => ("lean", contender.into()),
    }
}

impl Figures for ScreenSpace {
    fn device(&self) -> Device {
        (self.0.first()).map_or(Device::default(), |m| m.device.clone())
    }

    fn tables(&self) -> Vec<Table> {
        let sizes = self.sizes().into_iter();
        let kinds = |size| Kind::ALL.map(|kind| self.table(size, kind));
        // `none` belongs to all kinds.
        sizes
            .flat_map(kinds)
            .filter(|table| table.rows.len() > 1)
            .collect()
    }

    fn legend(&self) -> String {
        let frames = self.0.first().and_then(|m| m.frames);
        format!(
            "Median{} in ms. Stages are timed one by one; together they take less. Lighting: what the lighting pass takes \
             more than without effects. Bytes a pixel: each texture once written and once read, but for depth and normals. \
             RMSE (bias) against what is known: groove (albedo 0.5, of its light), wall and sphere (of πL); a mirror with outlines and without them (inside), and floors by their \
             roughness under a glowing quad (of its light)",
            frames.map_or(String::new(), |n| format!(" of {n} frames"))
        )
    }

    fn plots(&self) -> Vec<Plot> {
        let kinds = Kind::ALL
            .into_iter()
            .filter(|kind| self.of_kind(*kind).next().is_some());
        let mut plots: Vec<Plot> = kinds
            .flat_map(|kind| {
                let mut plots = self.speeds(kind);
                plots.push(self.stages(kind));
                plots
            })
            .collect();
        plots.push(self.bytes());
        plots
    }
}
