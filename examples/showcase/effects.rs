//! The effects, one by one.

use bevy::{camera::Exposure, prelude::*};
use bevy_lean_deferred::prelude::*;
use street::Viewpoint;

/// An effect on a lean camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    AmbientOcclusion,
    DiffuseGi,
    Reflections,
    SubsurfaceScattering,
    AutoExposure,
}

impl Effect {
    pub const ALL: [Self; 5] = [
        Self::AmbientOcclusion,
        Self::DiffuseGi,
        Self::Reflections,
        Self::SubsurfaceScattering,
        Self::AutoExposure,
    ];

    pub fn component(self) -> &'static str {
        match self {
            Self::AmbientOcclusion => "LeanScreenSpaceAmbientOcclusion",
            Self::DiffuseGi => "LeanScreenSpaceGi",
            Self::Reflections => "LeanScreenSpaceReflections",
            Self::SubsurfaceScattering => "LeanSubsurfaceScattering",
            Self::AutoExposure => "LeanAutoExposure",
        }
    }

    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::AmbientOcclusion => "ambient_occlusion",
            Self::DiffuseGi => "diffuse_gi",
            Self::Reflections => "reflections",
            Self::SubsurfaceScattering => "subsurface",
            Self::AutoExposure => "auto_exposure",
        }
    }

    pub fn key(self) -> KeyCode {
        match self {
            Self::AmbientOcclusion => KeyCode::KeyO,
            Self::DiffuseGi => KeyCode::KeyG,
            Self::Reflections => KeyCode::KeyR,
            Self::SubsurfaceScattering => KeyCode::KeyS,
            Self::AutoExposure => KeyCode::KeyE,
        }
    }

    /// The viewpoint that shows it best.
    pub fn viewpoint(self) -> Viewpoint {
        match self {
            Self::AmbientOcclusion | Self::DiffuseGi => Viewpoint::STALL,
            Self::Reflections => Viewpoint::PUDDLE,
            Self::SubsurfaceScattering => Viewpoint::CATS,
            Self::AutoExposure => Viewpoint::STREET,
        }
    }

    /// The exposure of a picture that shows the effect, if it is not the scene's.
    pub fn exposure(self) -> Option<Exposure> {
        // The exposure for daylight, which the effect has to correct.
        (self == Self::AutoExposure).then_some(Exposure { ev100: 8.0 })
    }

    pub fn switch(self, camera: &mut EntityCommands, is_on: bool) {
        match (self, is_on) {
            (Self::AmbientOcclusion, true) => {
                camera.insert(LeanScreenSpaceAmbientOcclusion::default());
            }
            (Self::AmbientOcclusion, false) => {
                camera.remove::<LeanScreenSpaceAmbientOcclusion>();
            }
            (Self::DiffuseGi, true) => {
                camera.insert(LeanScreenSpaceGi::default());
            }
            (Self::DiffuseGi, false) => {
                camera.remove::<LeanScreenSpaceGi>();
            }
            (Self::Reflections, true) => {
                camera.insert(LeanScreenSpaceReflections::default());
            }
            (Self::Reflections, false) => {
                camera.remove::<LeanScreenSpaceReflections>();
            }
            (Self::SubsurfaceScattering, true) => {
                camera.insert(LeanSubsurfaceScattering::default());
            }
            (Self::SubsurfaceScattering, false) => {
                camera.remove::<LeanSubsurfaceScattering>();
            }
            (Self::AutoExposure, true) => {
                camera.insert(LeanAutoExposure {
                    // Keeps a night dark.
                    target: 0.1,
                    ..default()
                });
            }
            (Self::AutoExposure, false) => {
                camera.remove::<LeanAutoExposure>();
            }
        }
    }

    /// Tells if a GPU span belongs to this effect.
    pub fn owns(self, span: &str) -> bool {
        let Some(pass) = span.strip_prefix("lean_deferred/") else {
            return false;
        };
        let folder = match self {
            // Only reflections need the history.
            Self::Reflections if pass.ends_with("history") => return true,
            effect => effect.name(),
        };
        pass.split('/').any(|part| part == folder)
    }
}
