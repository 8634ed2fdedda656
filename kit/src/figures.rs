//! What benches do with what they have measured.

use serde::Serialize;

/// A cell of a table: so many digits, or a dash for what was not measured.
pub fn figure(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".into(), |value| format!("{value:.digits$}"))
}

/// Writes a JSON file, or says why it cannot and ends the process.
pub fn write_json(path: &str, figures: &impl Serialize) {
    let json = serde_json::to_string_pretty(figures).expect("plain figures serialise");
    if let Err(error) = std::fs::write(path, json) {
        eprintln!("cannot write {path}: {error}");
        std::process::exit(1);
    }
}
