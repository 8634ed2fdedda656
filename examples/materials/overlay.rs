//! The text in the corner: the settings, the keys, the times, the bytes and the rows.

use core::fmt::Write;

use bevy::{diagnostic::DiagnosticsStore, prelude::*};
use bevy_lean_deferred::gbuffer::GBufferUsage;

use crate::{
    rows::ROWS,
    settings::{ExampleSettings, Shown},
};
use kit::example::{
    gpu_times,
    text_panel::{TextPanel, spawn_text_panel},
};

pub struct OverlayPlugin;

impl Plugin for OverlayPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Startup, spawn_text_panel)
            .add_systems(Update, update_text);
    }
}

const KEYS: &str =
    "1 both  2 lean  3 forward  D debug view  B split  L sun  E environment  S scattering  H text";

fn update_text(
    settings: Res<ExampleSettings>,
    diagnostics: Res<DiagnosticsStore>,
    lean: Query<&GBufferUsage>,
    panel: Single<(&mut Text, &mut Visibility), With<TextPanel>>,
) {
    let (mut text, mut visibility) = panel.into_inner();
    if !settings.text {
        *visibility = Visibility::Hidden;
        return;
    }
    *visibility = Visibility::Inherited;
    text.0 = describe(&settings);
    if let Some(usage) = lean.iter().find(|usage| usage.is_active()) {
        let time = |span| gpu_times::text(&diagnostics, span);
        let targets: Vec<_> = usage.each().map(|(name, _)| name).collect();
        let _ = write!(
            text.0,
            "\nG-buffer: {}: {} bytes a pixel beside depth\nGPU: G-buffer {}, lighting {}",
            targets.join(", "),
            usage.bytes_per_pixel(),
            time("lean_deferred/gbuffer"),
            time("lean_deferred/lighting"),
        );
    }
    let _ = write!(text.0, "\n{KEYS}");
    for row in &ROWS {
        let _ = write!(text.0, "\n{}: {}", row.name, row.steps);
    }
}

fn describe(settings: &ExampleSettings) -> String {
    let shown = match settings.shown {
        Shown::Both => "lean beside forward",
        Shown::Lean => "lean",
        Shown::Forward => "forward",
    };
    match settings.debug.view {
        Some(view) if settings.shown != Shown::Forward => format!("{shown}, {view:?}"),
        _ => shown.into(),
    }
}
