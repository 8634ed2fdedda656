//! Folders of figures.

use std::{collections::BTreeMap, path::Path};

use serde::{Deserialize, Serialize};

use crate::{
    benches::Bench,
    json::read_json,
    record::{Record, find},
};

/// The figures of some machines: `h200/frame_times` is the file that the bench `frame_times` wrote into the folder
/// `h200`.
#[derive(Default)]
pub struct Store {
    benches: BTreeMap<String, (Bench, Vec<Record>)>,
}

impl Store {
    /// Reads the figures in the folders of `folder`.
    pub fn of_machines(folder: &Path) -> Result<Self, String> {
        let mut store = Self::default();
        for (name, path) in list(folder)?.into_iter().filter(|(_, path)| path.is_dir()) {
            for bench in benches_in(&path)? {
                store.insert(&format!("{name}/{}", bench.name()), bench);
            }
        }
        Ok(store)
    }

    pub fn insert(&mut self, source: &str, bench: Bench) {
        let records = bench.records();
        self.benches.insert(source.into(), (bench, records));
    }

    pub fn contains(&self, source: &str) -> bool {
        self.benches.contains_key(source)
    }

    pub fn bench(&self, source: &str) -> Result<&Bench, String> {
        let found = self.benches.get(source);
        Ok(&found.ok_or(format!("there are no figures {source}"))?.0)
    }

    /// All records of a source that have all of `keys`.
    pub fn records(&self, source: &str, keys: &[&str]) -> Result<Vec<&Record>, String> {
        let found = self.benches.get(source);
        let (_, records) = found.ok_or(format!("there are no figures {source}"))?;
        let has_all = |record: &&Record| keys.iter().all(|key| record.has(key));
        Ok(records.iter().filter(has_all).collect())
    }

    /// The only record of a source that has all of `keys`.
    pub fn record(&self, source: &str, keys: &[&str]) -> Result<&Record, String> {
        let found = self.benches.get(source);
        let (_, records) = found.ok_or(format!("there are no figures {source}"))?;
        find(records, keys).map_err(|error| format!("{source}: {error}"))
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
