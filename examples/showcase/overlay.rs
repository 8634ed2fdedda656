//! The text in the corner: the renderer, the effects and their costs.

use bevy::{
    diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    prelude::*,
};
use kit::{
    example::{
        gpu_times,
        text_panel::{TextPanel, spawn_text_panel},
    },
    renderer::Renderer,
};

use crate::{effects::Effect, settings::Settings};

pub struct OverlayPlugin;

impl Plugin for OverlayPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(FrameTimeDiagnosticsPlugin::default())
            .add_systems(Startup, spawn_text_panel)
            .add_systems(Update, update_text);
    }
}

const KEYS: &str = "1 forward  2 deferred  3 lean  V viewpoint  P walk  H text";

fn update_text(
    settings: Res<Settings>,
    diagnostics: Res<DiagnosticsStore>,
    lights: Query<(), Or<(With<PointLight>, With<SpotLight>)>>,
    overlay: Single<(&mut Text, &mut Visibility), With<TextPanel>>,
) {
    let (mut text, mut visibility) = overlay.into_inner();
    if !settings.text {
        *visibility = Visibility::Hidden;
        return;
    }
    *visibility = Visibility::Inherited;
    let rate = diagnostics
        .get(&FrameTimeDiagnosticsPlugin::FPS)
        .and_then(|rate| rate.smoothed())
        .unwrap_or_default();
    let stages: &[&str] = match settings.renderer {
        Renderer::Forward => &["main_opaque_pass_3d"],
        Renderer::BevyDeferred => &["early deferred prepass", "main_opaque_pass_3d"],
        Renderer::Lean => &["lean_deferred/gbuffer", "lean_deferred/lighting"],
    };
    let mut lines = format!(
        "{}: {} lights, {rate:.0} frames a second\n",
        settings.renderer.name(),
        lights.iter().count()
    );
    for stage in stages {
        let time = gpu_times::text(&diagnostics, stage);
        lines.push_str(&format!("{stage}: {time}\n"));
    }
    if settings.renderer == Renderer::Lean {
        let spans = gpu_times::all(&diagnostics);
        for effect in Effect::ALL {
            let is_on = settings.effects.contains(&effect);
            let own = spans.iter().filter(|(span, _)| effect.owns(span));
            let time: f64 = own.map(|(_, milliseconds)| milliseconds).sum();
            let state = match is_on {
                true => format!("{time:.3} ms"),
                false => "off".into(),
            };
            let key = format!("{:?}", effect.key());
            let key = key.trim_start_matches("Key");
            lines.push_str(&format!("{key} {}: {state}\n", effect.component()));
        }
    }
    text.0 = lines + KEYS;
}
