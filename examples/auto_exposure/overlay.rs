//! The text in the corner: the settings, the metered values, the times and the keys.

use core::fmt::Write;

use bevy::{diagnostic::DiagnosticsStore, prelude::*};
use bevy_lean_deferred::prelude::*;

use crate::settings::{ExampleSettings, Mode, Pattern};
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
    "1 off  2 lean  3 Bevy's  Space walk  G LeanDeferred  M metering  P pattern  T trim  Up/Down target
Left/Right compensation  C curve  PgUp/PgDn speeds  I instant  R reduction  X cut  D weights  B split  H text";

fn update_text(
    settings: Res<ExampleSettings>,
    diagnostics: Res<DiagnosticsStore>,
    camera: Single<Option<&MeteredExposure>, With<Camera3d>>,
    overlay: Single<(&mut Text, &mut Visibility), With<TextPanel>>,
) {
    let (mut text, mut visibility) = overlay.into_inner();
    if !settings.text {
        *visibility = Visibility::Hidden;
        return;
    }
    *visibility = Visibility::Inherited;
    text.0 = describe(&settings);
    if settings.mode == Mode::Lean
        && let Some(exposure) = *camera
    {
        let _ = write!(text.0, "\n{}", metered(exposure));
    }
    let _ = write!(text.0, "\nGPU: {}\n{KEYS}", times(&settings, &diagnostics));
}

/// The metered values that were read back.
pub fn metered(metered: &MeteredExposure) -> String {
    let MeteredExposure {
        luminance,
        exposure,
        target_exposure,
    } = metered;
    format!(
        "luminance {luminance:.4}, exposure {exposure:+.2} stops, heading for {target_exposure:+.2}"
    )
}

fn describe(settings: &ExampleSettings) -> String {
    let camera = if settings.lean_deferred {
        "LeanDeferred"
    } else {
        "Bevy forward"
    };
    let exposure = &settings.exposure;
    let trim = match exposure.trim {
        Some(trim) => format!(
            "without the darkest {:.0} % and the brightest {:.0} %",
            100.0 * trim.low,
            100.0 * trim.high
        ),
        None => "untrimmed".into(),
    };
    let target = format!(
        "target {:.2}, compensation {:+.2} stops, curve {}",
        exposure.target,
        exposure.compensation,
        if settings.curve { "on" } else { "off" },
    );
    let speeds = format!(
        "{} stops a second into light, {} into the dark",
        exposure.speed_brighten, exposure.speed_darken
    );
    match settings.mode {
        Mode::Off => format!("{camera}, no auto exposure"),
        Mode::Bevy => {
            let pattern = match settings.pattern {
                Pattern::Mask => "Mask",
                _ => "Average",
            };
            format!("{camera}, Bevy's AutoExposure, {pattern}, {trim}\n{target}\n{speeds}")
        }
        Mode::Lean => format!(
            "{camera}, LeanAutoExposure {:?}, {:?}, {trim}\n{target}\n{}, reduction {:?}",
            exposure.metering,
            settings.pattern,
            if exposure.advanced.instant {
                "instant"
            } else {
                &speeds
            },
            exposure.advanced.reduction,
        ),
    }
}

/// Times of the passes that run now: the diagnostics of others keep their last times.
fn times(settings: &ExampleSettings, diagnostics: &DiagnosticsStore) -> String {
    let time = |span| gpu_times::text(diagnostics, span);
    match settings.mode {
        Mode::Off => "-".into(),
        Mode::Bevy => format!("auto_exposure {}", time("auto_exposure")),
        Mode::Lean => time("lean_deferred/effects/auto_exposure"),
    }
}
