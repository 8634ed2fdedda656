//! GPU times as `RenderDiagnosticsPlugin` records them.

use bevy::diagnostic::{Diagnostic, DiagnosticsStore};

/// Spans and their mean times in milliseconds, longest first.
pub fn all(diagnostics: &DiagnosticsStore) -> Vec<(&str, f64)> {
    let mut times: Vec<(&str, f64)> = diagnostics
        .iter()
        .filter_map(|diagnostic| Some((span(diagnostic)?, diagnostic.average()?)))
        .collect();
    times.sort_by(|a, b| b.1.total_cmp(&a.1));
    times
}

/// Mean time of one span, or a dash if it has none.
pub fn text(diagnostics: &DiagnosticsStore, name: &str) -> String {
    diagnostics
        .iter()
        .find(|diagnostic| span(diagnostic) == Some(name))
        .and_then(|diagnostic| diagnostic.average())
        .map_or("-".into(), |milliseconds| format!("{milliseconds:.3} ms"))
}

/// Mean time of one span in milliseconds, regardless of its enclosing spans.
pub fn mean(diagnostics: &DiagnosticsStore, name: &str) -> Option<f64> {
    let is_it = |path: &str| {
        let around = path.strip_suffix(name);
        around.is_some_and(|around| around.is_empty() || around.ends_with('/'))
    };
    diagnostics
        .iter()
        .filter(|diagnostic| span(diagnostic).is_some_and(is_it))
        .find_map(Diagnostic::average)
}

/// Clears all recorded times.
pub fn forget(diagnostics: &mut DiagnosticsStore) {
    for diagnostic in diagnostics.iter_mut() {
        if span(diagnostic).is_some() {
            diagnostic.clear_history();
        }
    }
}

fn span(diagnostic: &Diagnostic) -> Option<&str> {
    diagnostic
        .path()
        .as_str()
        .strip_prefix("render/")?
        .strip_suffix("/elapsed_gpu")
}
