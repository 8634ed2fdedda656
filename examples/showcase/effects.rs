//! The effects, one by one.

use bevy::{camera::Exposure, prelude::*};
use bevy_lean_deferred::prelude::*;
use kit::example::switch::switch;

use crate::settings::Place;

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

    /// The viewpoint that shows it best.
    pub fn place(self) -> Place {
        match self {
            Self::AmbientOcclusion | Self::DiffuseGi => Place::Stall,
            Self::Reflections => Place::Puddle,
            Self::SubsurfaceScattering => Place::Cats,
            Self::AutoExposure => Place::Street,
        }
    }

    /// The exposure of a picture that shows the effect, if it is not the scene's.
    pub fn exposure(self) -> Option<Exposure> {
        // The exposure for daylight, which the effect has to correct.
        (self == Self::AutoExposure).then_some(Exposure { ev100: 8.0 })
    }

    pub fn switch(self, camera: &mut EntityCommands, is_on: bool) {
        match self {
            Self::AmbientOcclusion => switch::<LeanScreenSpaceAmbientOcclusion>(camera, is_on),
            Self::DiffuseGi => switch::<LeanScreenSpaceGi>(camera, is_on),
            Self::Reflections => switch::<LeanScreenSpaceReflections>(camera, is_on),
            Self::SubsurfaceScattering => switch::<LeanSubsurfaceScattering>(camera, is_on),
            Self::AutoExposure if is_on => {
                camera.insert_if_new(night_exposure());
            }
            Self::AutoExposure => switch::<LeanAutoExposure>(camera, false),
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

/// Auto exposure that keeps a night dark.
pub fn night_exposure() -> LeanAutoExposure {
    LeanAutoExposure {
        target: 0.1,
        ..default()
    }
}
