//! The text in the corner: the settings, the keys and the times.

use bevy::{diagnostic::DiagnosticsStore, prelude::*};

use crate::settings::{Effect, ExampleSettings, Mirrors};
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

const KEYS: &str = "1 none  2 occlusion  3 GI  Q quality  R resolution  Up/Down radius  M mirrors  D debug view  B split  L lights  H text";

fn update_text(
    settings: Res<ExampleSettings>,
    diagnostics: Res<DiagnosticsStore>,
    overlay: Single<(&mut Text, &mut Visibility), With<TextPanel>>,
) {
    let (mut text, mut visibility) = overlay.into_inner();
    if !settings.text {
        *visibility = Visibility::Hidden;
        return;
    }
    *visibility = Visibility::Inherited;
    let time = |name| gpu_times::text(&diagnostics, name);
    let gi = &settings.gi;
    let effect = match settings.effect {
        Effect::None => "no effect".into(),
        Effect::Occlusion => format!(
            "LeanScreenSpaceAmbientOcclusion: {}",
            time("lean_deferred/effects/ambient_occlusion/gather")
        ),
        Effect::Gi => format!(
            "LeanScreenSpaceGi {}, {}, {:.1} m: {}",
            gi.quality,
            gi.resolution,
            gi.radius,
            time("lean_deferred/effects/diffuse_gi"),
        ),
    };
    let mirrors = match settings.mirrors {
        Mirrors::Off => "no reflections".into(),
        Mirrors::Bevy => format!("Bevy's ScreenSpaceReflections: {}", time("ssr")),
        quality => format!(
            "LeanScreenSpaceReflections {quality:?}, {}: {}, last frame {}",
            gi.resolution,
            time("lean_deferred/effects/reflections"),
            time("lean_deferred/effects/history"),
        ),
    };
    text.0 = format!(
        "{effect}\n{mirrors}\nlighting {}\n{KEYS}",
        time("lean_deferred/lighting")
    );
}
