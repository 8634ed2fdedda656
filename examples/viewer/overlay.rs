//! The text in the corner: the model, the settings and the times.

use core::fmt::Write;

use bevy::{diagnostic::DiagnosticsStore, prelude::*};
use bevy_lean_deferred::{EffectStatus, LeanStatus};

use crate::renderer::ViewerSettings;
use kit::{
    example::{dropped_model::DropMessage, gpu_times, model::ModelPath},
    renderer::Renderer,
};

pub struct OverlayPlugin;

impl Plugin for OverlayPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Startup, spawn_text)
            .add_systems(Update, update_text);
    }
}

#[derive(Component)]
struct OverlayText;

fn spawn_text(mut commands: Commands) {
    commands.spawn((
        OverlayText,
        Text::default(),
        TextFont::from_font_size(14.0),
        Node {
            position_type: PositionType::Absolute,
            top: px(8),
            left: px(10),
            ..default()
        },
    ));
}

/// The state of lean rendering, with the reason if Bevy renders.
fn lean_text(status: Option<&LeanStatus>) -> String {
    match status.map(|status| &status.deferred) {
        Some(EffectStatus::On) => "lean".into(),
        Some(status) => format!("lean: {status}"),
        None => "lean: no camera".into(),
    }
}

fn update_text(
    settings: Res<ViewerSettings>,
    diagnostics: Res<DiagnosticsStore>,
    status: Query<&LeanStatus>,
    model: Res<ModelPath>,
    drop: Option<Res<DropMessage>>,
    mut text: Single<&mut Text, With<OverlayText>>,
) {
    text.0.clear();
    if !settings.text {
        return;
    }
    let out = &mut text.0;
    let _ = writeln!(out, "{}", model.0.as_deref().unwrap_or("built-in scene"));
    if let Some(message) = drop.as_ref().and_then(|drop| drop.0.as_deref()) {
        let _ = writeln!(out, "> {message}");
    }
    let _ = match settings.renderer {
        Renderer::Forward | Renderer::BevyDeferred => {
            writeln!(out, "{}", settings.renderer.name())
        }
        Renderer::Lean => writeln!(
            out,
            "{}{}",
            lean_text(status.iter().next()),
            (settings.debug.view).map_or(String::new(), |view| format!(", showing {view:?}"))
        ),
    };
    let _ = writeln!(
        out,
        "1 forward  2 deferred  3 lean  D debug view  B split  L sun  E environment  H text  drag a file here to show it"
    );
    for (name, milliseconds) in gpu_times::all(&diagnostics).into_iter().take(12) {
        if milliseconds < 0.0005 {
            break;
        }
        let _ = writeln!(out, "{milliseconds:7.3} ms  {name}");
    }
}
