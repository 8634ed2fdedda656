//! The text in the corner: the settings, the keys and the times.

use bevy::{diagnostic::DiagnosticsStore, prelude::*};

use crate::settings::{Effect, ExampleSettings};
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
    "1 none  2 occlusion  3 GI  Q quality  R resolution  Up/Down radius  L lights  H text";

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
            "LeanAmbientOcclusion: {}",
            time("lean_deferred/ambient_occlusion/gather")
        ),
        Effect::Gi => format!(
            "LeanScreenSpaceGi {:?}, {:?}, {:.1} m: levels {}, gather {}, filter {}",
            gi.quality,
            gi.resolution,
            gi.radius,
            time("lean_deferred/diffuse_gi/levels"),
            time("lean_deferred/diffuse_gi/gather"),
            time("lean_deferred/diffuse_gi/filter"),
        ),
    };
    text.0 = format!(
        "{effect}\nlighting {}\n{KEYS}",
        time("lean_deferred/lighting")
    );
}
