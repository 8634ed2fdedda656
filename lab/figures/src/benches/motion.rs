//! Screen-space reflections and GI in motion, and beneath small lamps.

use serde::{Deserialize, Serialize};

use super::{Figures, distinct};
use crate::{
    numbers::{fixed, rmse_and_bias},
    plots::Plot,
    table::Table,
    time::Device,
};

/// A contender on a path. Differences are of values shown, 0 to 1.
#[derive(Serialize, Deserialize, Clone)]
pub struct PathMeasurement {
    #[serde(flatten)]
    pub device: Device,
    pub size: [u32; 2],
    /// The effect that the scene shows.
    pub subject: String,
    pub contender: String,
    pub path: String,
    /// Frames of the path that were compared with the truth.
    pub frames: Vec<usize>,
    /// Their RMSE, that of the camera at rest in the same poses, and their mean FLIP.
    pub rmse: Vec<f32>,
    pub rest: Vec<f32>,
    pub flip: Vec<f32>,
    /// RMS of what compared frames change beyond the changes of the truth.
    pub flicker: f32,
    /// Largest RMS between two consecutive frames at rest.
    pub flicker_at_rest: f32,
    /// In frames.
    pub trail: usize,
    /// Frames of a switched lamp until nine tenths of its light, or of its absence: the longer.
    pub lag: Option<usize>,
}

/// A floor beneath a lamp. Errors are shares of the brightest light of the floor.
#[derive(Serialize, Deserialize, Clone)]
pub struct LampMeasurement {
    #[serde(flatten)]
    pub device: Device,
    pub size: [u32; 2],
    pub subject: String,
    pub contender: String,
    pub light: f32,
    /// `None` for diffuse floors.
    pub roughness: Option<f32>,
    /// Frames after a cut.
    pub frames: usize,
    pub rmse: f32,
    pub bias: f32,
    /// Largest relative difference of a place under an upright and under a rolled camera.
    pub rotation: f32,
}

#[derive(Serialize, Deserialize, Default)]
#[serde(default)]
pub struct Motion {
    pub paths: Vec<PathMeasurement>,
    pub lamps: Vec<LampMeasurement>,
}

fn mean(values: &[f32]) -> Option<f64> {
    let sum: f32 = values.iter().sum();
    (!values.is_empty()).then(|| f64::from(sum) / values.len() as f64)
}

fn largest(values: &[f32]) -> Option<f64> {
    values.iter().copied().reduce(f32::max).map(f64::from)
}

impl PathMeasurement {
    /// Error in motion as a factor on that at rest.
    pub fn of_rest(&self) -> Option<f64> {
        let rest = mean(&self.rest).filter(|rest| *rest > 0.0)?;
        Some(mean(&self.rmse)? / rest)
    }

    fn row(&self) -> Vec<String> {
        vec![
            self.path.clone(),
            self.contender.clone(),
            fixed(mean(&self.rmse), 4),
            fixed(largest(&self.rmse), 4),
            fixed(mean(&self.rest), 4),
            fixed(self.of_rest(), 2),
            fixed(mean(&self.flip), 4),
            fixed(largest(&self.flip), 4),
            fixed(f64::from(self.flicker), 4),
            fixed(f64::from(self.flicker_at_rest), 4),
            self.trail.to_string(),
            fixed(self.lag.map(|lag| lag as f64), 0),
        ]
    }
}

impl LampMeasurement {
    fn row(&self) -> Vec<String> {
        let floor = match self.roughness {
            Some(roughness) => format!("{roughness}"),
            None => "diffuse".into(),
        };
        vec![
            floor,
            format!("{}", self.light),
            self.contender.clone(),
            self.frames.to_string(),
            rmse_and_bias(Some((self.rmse.into(), self.bias.into()))),
            fixed(f64::from(self.rotation), 2),
        ]
    }
}

const PATH_COLUMNS: [&str; 12] = [
    "path",
    "contender",
    "RMSE",
    "worst",
    "at rest",
    "× rest",
    "FLIP",
    "worst",
    "flicker",
    "flicker at rest",
    "trail",
    "lag",
];

const LAMP_COLUMNS: [&str; 6] = [
    "roughness",
    "light",
    "contender",
    "frames",
    "RMSE (bias)",
    "rotation",
];

impl Motion {
    pub fn join(&mut self, more: Self) {
        self.paths.extend(more.paths);
        self.lamps.extend(more.lamps);
    }
}

/// A table for each size and subject among `measured`, which `scene` returns; rows of one scene are beside one another.
fn tables_of<'a, M>(
    measured: &'a [M],
    columns: &[&str],
    title: &str,
    scene: impl Fn(&'a M) -> ([u32; 2], &'a str),
    row: impl Fn(&'a M) -> Vec<String>,
) -> Vec<Table> {
    let scenes = distinct(measured.iter().map(&scene));
    let table = |(size, subject): ([u32; 2], &'a str)| {
        let of_scene = measured.iter().filter(|m| scene(m) == (size, subject));
        // By their first cells, in order of appearance.
        let rows: Vec<Vec<String>> = of_scene.map(&row).collect();
        let firsts = distinct(rows.iter().map(|row| row[0].clone()));
        let sorted = firsts
            .iter()
            .flat_map(|first| rows.iter().filter(move |row| row[0] == *first).cloned());
        let [x, y] = size;
        Table::new(columns, sorted).titled(format!("**{x}×{y}**, {subject}{title}"))
    };
    scenes.into_iter().map(table).collect()
}

impl Figures for Motion {
    fn device(&self) -> Device {
        let path = self.paths.first().map(|m| m.device.clone());
        let lamp = || self.lamps.first().map(|m| m.device.clone());
        path.or_else(lamp).unwrap_or_default()
    }

    fn tables(&self) -> Vec<Table> {
        let mut tables = tables_of(
            &self.paths,
            &PATH_COLUMNS,
            "",
            |m| (m.size, &*m.subject),
            PathMeasurement::row,
        );
        tables.extend(tables_of(
            &self.lamps,
            &LAMP_COLUMNS,
            ", beneath a lamp",
            |m| (m.size, &*m.subject),
            LampMeasurement::row,
        ));
        tables
    }

    fn legend(&self) -> String {
        "Differences of values shown (0 to 1) from the same effect at rest in the same pose, converged at its best quality. Mean of the \
         compared frames, and the worst of them; at rest: of the contender at rest in these poses. Flicker: RMS of what frames change \
         beyond the truth. Trail: frames for which a tenth of what is gone still shows, at most 16. Lag: frames of a switched lamp \
         until nine tenths of its light, or all until the next switch. Beneath lamps: errors as shares of the brightest light of the \
         floor, so many frames after a cut; rotation: the largest relative difference between an upright and a rolled camera"
            .into()
    }

    fn plots(&self) -> Vec<Plot> {
        Vec::new()
    }
}
