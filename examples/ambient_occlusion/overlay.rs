//! The text in the corner: the settings, the keys, the time and the error.

use core::fmt::Write;

use bevy::{diagnostic::DiagnosticsStore, prelude::*};
use bevy_lean_deferred::{
    effects::ambient_occlusion::{OcclusionApplication, OcclusionKernel, OcclusionNormals},
    prelude::*,
};

use crate::{
    errors,
    settings::{ExampleSettings, Mode},
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
    "1 off  2 lean  3 Bevy's  G LeanDeferred  P quality  K kernel  A application  D occlusion alone  B split
Up/Down radius  Left/Right intensity  R resolution  F filter  E edges  N normals  L sun  H text";

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
    text.0 = describe(&settings);
    let _ = write!(
        text.0,
        "\nGPU: {}\n{}\n{KEYS}",
        times(&settings, &diagnostics),
        errors::text(&settings),
    );
}

fn describe(settings: &ExampleSettings) -> String {
    let camera = if settings.lean_deferred {
        "LeanDeferred"
    } else {
        "Bevy forward"
    };
    let occlusion = &settings.occlusion;
    match settings.mode {
        Mode::Off => format!("{camera}, no ambient occlusion"),
        Mode::Bevy => format!(
            "{camera}, Bevy's ScreenSpaceAmbientOcclusion {:?}",
            settings.bevy_level()
        ),
        Mode::Lean => format!(
            "{camera}, LeanScreenSpaceAmbientOcclusion {}, radius {:.2} m, intensity {:.1}\n{}, {}, {:?}{}, {} normals{}",
            sampling(occlusion),
            occlusion.radius,
            occlusion.intensity,
            application(occlusion.application, settings.lean_deferred),
            occlusion.resolution,
            occlusion.advanced.filter,
            if occlusion.advanced.edge_aware {
                ""
            } else {
                " across edges"
            },
            normals(occlusion, settings.lean_deferred),
            if settings.debug.view.is_some() {
                ", occlusion alone"
            } else {
                ""
            },
        ),
    }
}

/// Times of the passes that run now: the diagnostics of others keep their last times.
fn times(settings: &ExampleSettings, diagnostics: &DiagnosticsStore) -> String {
    let time = |span| gpu_times::text(diagnostics, span);
    let gather = "lean_deferred/effects/ambient_occlusion/gather";
    match settings.mode {
        Mode::Off => "-".into(),
        Mode::Bevy => format!("ssao {}", time("ssao")),
        Mode::Lean if is_merged(settings) => format!(
            "gather {}, merge {}",
            time(gather),
            time("lean_deferred/effects/ambient_occlusion/merge")
        ),
        Mode::Lean => format!("gather {}, merged by the lighting pass", time(gather)),
    }
}

fn is_merged(settings: &ExampleSettings) -> bool {
    resolve(settings.occlusion.application, settings.lean_deferred)
        == OcclusionApplication::MultiplicativeBlend
}

fn sampling(occlusion: &LeanScreenSpaceAmbientOcclusion) -> String {
    match occlusion.advanced.kernel {
        OcclusionKernel::Hdao => "HDAO".into(),
        OcclusionKernel::Hbao => {
            let (slices, steps) = occlusion.samples();
            format!("HBAO {} ({slices} x 2 x {steps})", occlusion.quality)
        }
    }
}

/// The application that a camera ends up with.
fn resolve(chosen: OcclusionApplication, lean_deferred: bool) -> OcclusionApplication {
    match chosen {
        OcclusionApplication::MultiplicativeBlend => chosen,
        _ if lean_deferred => OcclusionApplication::Indirect,
        _ => OcclusionApplication::MultiplicativeBlend,
    }
}

/// The chosen application, and the resolved one if it differs.
fn application(chosen: OcclusionApplication, lean_deferred: bool) -> String {
    let used = resolve(chosen, lean_deferred);
    if used == chosen {
        format!("{chosen:?}")
    } else {
        format!("{chosen:?}: {used:?}")
    }
}

fn normals(occlusion: &LeanScreenSpaceAmbientOcclusion, lean_deferred: bool) -> &'static str {
    match (occlusion.advanced.kernel, occlusion.advanced.normals) {
        (OcclusionKernel::Hdao, _) => "no",
        (OcclusionKernel::Hbao, OcclusionNormals::Shading) if lean_deferred => "shading",
        (OcclusionKernel::Hbao, _) => "geometric",
    }
}
