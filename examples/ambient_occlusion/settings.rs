//! Settings that the keys change, and the system that applies them to the camera.

use bevy::{
    core_pipeline::{
        prepass::{DepthPrepass, NormalPrepass},
        tonemapping::Tonemapping,
    },
    pbr::{ScreenSpaceAmbientOcclusion, ScreenSpaceAmbientOcclusionQualityLevel},
    prelude::*,
};
use bevy_lean_deferred::{
    effects::ambient_occlusion::{
        OcclusionApplication, OcclusionFilter, OcclusionKernel, OcclusionNormals,
    },
    prelude::*,
};

use crate::courtyard::Sun;
use kit::example::{choices::next, debug_view::DebugChoice};

/// The occlusion technique on the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    Off,
    Lean,
    Bevy,
}

pub const MODES: [Mode; 3] = [Mode::Off, Mode::Lean, Mode::Bevy];
pub const APPLICATIONS: [OcclusionApplication; 3] = [
    OcclusionApplication::Auto,
    OcclusionApplication::MultiplicativeBlend,
    OcclusionApplication::Indirect,
];
pub const KERNELS: [OcclusionKernel; 2] = [OcclusionKernel::Hbao, OcclusionKernel::Hdao];
pub const NORMALS: [OcclusionNormals; 2] = [OcclusionNormals::Shading, OcclusionNormals::Geometric];

/// Factor between two radii.
const RADIUS_STEP: f32 = 1.25;
const INTENSITY_STEP: f32 = 0.1;

#[derive(Resource, Clone)]
pub struct ExampleSettings {
    pub mode: Mode,
    pub lean_deferred: bool,
    pub occlusion: LeanScreenSpaceAmbientOcclusion,
    /// Shows the occlusion alone.
    pub debug: DebugChoice,
    pub sun: bool,
    pub text: bool,
}

impl ExampleSettings {
    /// Bevy's level of the same name.
    pub fn bevy_level(&self) -> ScreenSpaceAmbientOcclusionQualityLevel {
        match self.occlusion.quality {
            LeanQuality::Low => ScreenSpaceAmbientOcclusionQualityLevel::Low,
            LeanQuality::Medium => ScreenSpaceAmbientOcclusionQualityLevel::Medium,
            LeanQuality::High => ScreenSpaceAmbientOcclusionQualityLevel::High,
            LeanQuality::Ultra => ScreenSpaceAmbientOcclusionQualityLevel::Ultra,
        }
    }
}

pub fn read_keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut settings: ResMut<ExampleSettings>,
    mut exit: MessageWriter<AppExit>,
) {
    for key in keys.get_just_pressed() {
        if *key == KeyCode::Escape {
            exit.write(AppExit::Success);
            continue;
        }
        // Destructured only once a key is pressed: mutable access marks the settings as changed.
        let ExampleSettings {
            mode,
            lean_deferred,
            occlusion,
            debug,
            sun,
            text,
        } = &mut *settings;
        let advanced = &mut occlusion.advanced;
        match key {
            KeyCode::Digit1 => *mode = Mode::Off,
            KeyCode::Digit2 => *mode = Mode::Lean,
            KeyCode::Digit3 => *mode = Mode::Bevy,
            KeyCode::KeyG => *lean_deferred = !*lean_deferred,
            KeyCode::KeyP => {
                occlusion.quality = next(&LeanQuality::ALL, occlusion.quality);
            }
            KeyCode::ArrowUp => occlusion.radius = (occlusion.radius * RADIUS_STEP).min(10.0),
            KeyCode::ArrowDown => occlusion.radius = (occlusion.radius / RADIUS_STEP).max(0.01),
            KeyCode::ArrowRight => {
                occlusion.intensity = (occlusion.intensity + INTENSITY_STEP).min(4.0);
            }
            KeyCode::ArrowLeft => {
                occlusion.intensity = (occlusion.intensity - INTENSITY_STEP).max(0.0);
            }
            KeyCode::KeyA => occlusion.application = next(&APPLICATIONS, occlusion.application),
            KeyCode::KeyK => advanced.kernel = next(&KERNELS, advanced.kernel),
            KeyCode::KeyR => {
                occlusion.resolution = next(&LeanResolution::ALL, occlusion.resolution);
            }
            KeyCode::KeyF => advanced.filter = next(&OcclusionFilter::ALL, advanced.filter),
            KeyCode::KeyE => advanced.edge_aware = !advanced.edge_aware,
            KeyCode::KeyN => advanced.normals = next(&NORMALS, advanced.normals),
            KeyCode::KeyD => debug.change_view(&[DebugView::AmbientOcclusion]),
            KeyCode::KeyB => debug.change_split(),
            KeyCode::KeyL => *sun = !*sun,
            KeyCode::KeyH => *text = !*text,
            _ => {}
        }
    }
}

pub fn apply(
    mut commands: Commands,
    settings: Res<ExampleSettings>,
    camera: Single<Entity, With<Camera3d>>,
    mut sun: Single<&mut Visibility, With<Sun>>,
) {
    **sun = if settings.sun {
        Visibility::Inherited
    } else {
        Visibility::Hidden
    };
    let mut camera = commands.entity(*camera);
    if settings.lean_deferred {
        camera.insert_if_new(LeanDeferred::default());
    } else {
        camera.remove::<LeanDeferred>();
    }
    if settings.mode != Mode::Lean {
        camera.remove::<LeanScreenSpaceAmbientOcclusion>();
    }
    if settings.mode != Mode::Bevy {
        camera.remove::<(ScreenSpaceAmbientOcclusion, DepthPrepass, NormalPrepass)>();
    }
    match settings.mode {
        Mode::Off => {}
        Mode::Lean => {
            camera.insert(settings.occlusion);
        }
        Mode::Bevy => {
            // Requires both prepasses. MSAA is off on this camera.
            camera.insert(ScreenSpaceAmbientOcclusion {
                quality_level: settings.bevy_level(),
                ..default()
            });
        }
    }
    settings.debug.put_on(&mut camera);
    let shows_data = settings.mode == Mode::Lean && settings.debug.is_whole();
    camera.insert(if shows_data {
        Tonemapping::None
    } else {
        Tonemapping::TonyMcMapface
    });
}
