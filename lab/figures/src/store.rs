//! Folders of figures.

use std::{collections::BTreeMap, path::Path};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{
    benches::Bench,
    json::{read_json, write_json},
};

/// The figures of some machines, each in a folder with the machine's name.
#[derive(Default)]
pub struct Store {
    machines: BTreeMap<String, Vec<Bench>>,
}

impl Store {
    /// Reads the figures in the folders of `folder`.
    pub fn of_machines(folder: &Path) -> Result<Self, String> {
        let mut store = Self::default();
        for (name, path) in list(folder)?.into_iter().filter(|(_, path)| path.is_dir()) {
            store.machines.insert(name, benches_in(&path)?);
        }
        Ok(store)
    }

    /// The figures of the bench `name` from `machine`.
    #[track_caller]
    pub fn bench(&self, machine: &str, name: &str) -> &Bench {
        let benches = self.machines.get(machine).into_iter().flatten();
        let mut found = benches.filter(|bench| bench.name() == name);
        found
            .next()
            .unwrap_or_else(|| panic!("there are no figures {machine}/{name}"))
    }
}

/// Facts about a folder of figures: its `run.json`.
#[derive(Serialize, Deserialize, Default, Clone)]
#[serde(default)]
pub struct Run {
    pub date: String,
    pub commit: String,
    /// Quick or full, and other remarks.
    pub note: String,
    /// Memory bandwidth of the GPU, in TB/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bandwidth: Option<f64>,
}

impl Run {
    pub fn of(folder: &Path) -> Result<Self, String> {
        let path = folder.join(Self::FILE);
        match path.exists() {
            true => read_json(&path),
            false => Ok(Self::default()),
        }
    }

    pub const FILE: &str = "run.json";
}

/// A folder of figures as one file, to be sent.
#[derive(Serialize, Deserialize)]
#[serde(transparent)]
pub struct Bundle {
    /// Files by their names.
    files: BTreeMap<String, Value>,
}

impl Bundle {
    /// The JSON files of `folder`.
    pub fn of(folder: &Path) -> Result<Self, String> {
        let files = list(folder)?;
        let files = files
            .into_iter()
            .filter(|(name, _)| name.ends_with(".json"));
        let read = |(name, path): (String, std::path::PathBuf)| Ok((name, read_json(&path)?));
        let files = files.map(read).collect::<Result<_, String>>()?;
        Ok(Self { files })
    }

    /// Writes the files into `folder`.
    pub fn unpack(&self, folder: &Path) -> Result<(), String> {
        let says = |error: std::io::Error| format!("{}: {error}", folder.display());
        std::fs::create_dir_all(folder).map_err(says)?;
        for (name, figures) in &self.files {
            // A bundle comes from elsewhere: its files stay in the folder.
            if Path::new(name).file_name() != Some(name.as_ref()) || !name.ends_with(".json") {
                return Err(format!("{name} is no name of a file of figures"));
            }
            write_json(&folder.join(name).to_string_lossy(), figures);
        }
        Ok(())
    }
}

/// Reads all files that benches wrote into `folder`. A bench may have written several, whose names begin with its own:
/// `frame_times.json` and `frame_times_crowd.json`.
pub fn benches_in(folder: &Path) -> Result<Vec<Bench>, String> {
    let mut benches: Vec<Bench> = Vec::new();
    let run = Run::of(folder)?;
    for (name, path) in list(folder)? {
        let Some(stem) = name.strip_suffix(".json") else {
            continue;
        };
        let is_first = |first: &&&str| {
            let rest = stem.strip_prefix(**first);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '_']))
        };
        let Some(first) = Bench::NAMES.iter().find(is_first) else {
            continue;
        };
        let mut bench = Bench::read(first, &path)?;
        if let Bench::LightScaling(figures) = &mut bench {
            figures.bandwidth = figures.bandwidth.or(run.bandwidth);
        }
        match benches.iter_mut().find(|other| other.name() == *first) {
            Some(other) => other.join(bench),
            None => benches.push(bench),
        }
    }
    Ok(benches)
}

/// Names and paths of the entries, sorted.
fn list(folder: &Path) -> Result<Vec<(String, std::path::PathBuf)>, String> {
    let says = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(says)? {
        let entry = entry.map_err(says)?;
        entries.push((
            entry.file_name().to_string_lossy().into_owned(),
            entry.path(),
        ));
    }
    entries.sort();
    Ok(entries)
}
