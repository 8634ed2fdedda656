//! Pictures of scenes in which crates of others draw: `lab/compat`.

use serde::{Deserialize, Serialize};

use super::Figures;
use crate::{
    numbers::{fixed, percent},
    plots::Plot,
    table::Table,
    time::Device,
};

/// A crate, and the pictures of its scene.
#[derive(Serialize, Deserialize, Clone, Default)]
pub struct Measurement {
    #[serde(flatten)]
    pub device: Device,
    pub size: [u32; 2],
    pub name: String,
    pub version: String,
    pub shows: String,
    /// Share of the picture that the crate changes.
    pub drawn: f64,
    /// False if Bevy rendered the lean camera.
    pub was_lean: bool,
    /// From forward, in dB; `None` for equal pictures.
    pub psnr: Option<f64>,
    /// PSNR within the pixels that the crate changes.
    pub psnr_drawn: Option<f64>,
    /// Numbers of meshes that went forward on the lean camera, by `ForwardReason`.
    pub forward: Vec<(String, usize)>,
    /// Share of pixels that differ from forward's first picture after lean was switched off.
    pub changed_back: f64,
    /// Warnings and errors of the lean camera.
    pub messages: Vec<String>,
    pub to_do: String,
}

#[derive(Serialize, Deserialize, Default)]
#[serde(transparent)]
pub struct Compat(pub Vec<Measurement>);

const COLUMNS: [&str; 8] = [
    "crate",
    "it draws",
    "of the picture",
    "PSNR",
    "where it draws",
    "meshes gone forward",
    "back",
    "what to do",
];

impl Compat {
    pub fn join(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    /// Adds a crate, or replaces it. Crates are sorted by their names.
    pub fn set(&mut self, measurement: Measurement) {
        self.0.retain(|other| other.name != measurement.name);
        self.0.push(measurement);
        self.0.sort_by(|a, b| a.name.cmp(&b.name));
    }

    /// A row for each crate.
    pub fn table(&self) -> Table {
        let decibel = |psnr: Option<f64>| psnr.map_or("equal".into(), |psnr| fixed(psnr, 1));
        let row = |m: &Measurement| {
            let reasons = m.forward.iter();
            let reasons: Vec<_> = reasons
                .map(|(reason, count)| format!("{count} `{reason}`"))
                .collect();
            vec![
                format!("`{}` {}", m.name, m.version),
                m.shows.clone(),
                percent(m.drawn, 1),
                match m.was_lean {
                    true => decibel(m.psnr),
                    false => "not lean".into(),
                },
                decibel(m.psnr_drawn),
                match reasons.is_empty() {
                    true => "none".into(),
                    false => reasons.join(", "),
                },
                match m.changed_back {
                    0.0 => "to the bit".into(),
                    share => format!("{} differ", percent(share, 2)),
                },
                m.to_do.clone(),
            ]
        };
        Table::new(&COLUMNS, self.0.iter().map(row))
    }
}

impl Figures for Compat {
    fn device(&self) -> Device {
        let first = self.0.first();
        first.map_or_else(Device::default, |m| m.device.clone())
    }

    fn tables(&self) -> Vec<Table> {
        vec![self.table()]
    }

    fn plots(&self) -> Vec<Plot> {
        Vec::new()
    }

    fn legend(&self) -> String {
        "PSNR of the lean camera's picture from forward's, in dB: of the whole picture, and of the pixels that the crate \
         changes. *Back*: forward's picture after lean and all effects were removed, beside forward's before."
            .into()
    }
}
