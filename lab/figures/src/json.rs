//! Figures in files.

use std::path::Path;

use serde::{Serialize, de::DeserializeOwned};

/// Writes a JSON file, or prints the error and ends the process.
pub fn write_json(path: &str, figures: &impl Serialize) {
    let json = serde_json::to_string_pretty(figures).expect("plain figures serialise");
    if let Err(error) = std::fs::write(path, json) {
        eprintln!("cannot write {path}: {error}");
        std::process::exit(1);
    }
}

pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, String> {
    let text = read_text(path)?;
    serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
}

pub fn read_text(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}
