//! The contenders.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::renderer::Renderer;

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    Forward,
    BevyDeferred,
    Lean,
    /// Lean with the effects of a preset.
    LeanEffects,
}

impl Contender {
    /// Forward first: it is the reference of the others.
    pub const ALL: [Self; 4] = [
        Self::Forward,
        Self::BevyDeferred,
        Self::Lean,
        Self::LeanEffects,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::LeanEffects => "lean with effects",
            _ => self.renderer().name(),
        }
    }

    pub fn renderer(self) -> Renderer {
        match self {
            Self::Forward => Renderer::Forward,
            Self::BevyDeferred => Renderer::BevyDeferred,
            Self::Lean | Self::LeanEffects => Renderer::Lean,
        }
    }

    pub fn is_lean(self) -> bool {
        self.renderer() == Renderer::Lean
    }

    /// Tells if its picture is to be forward's.
    pub fn is_compared(self) -> bool {
        matches!(self, Self::BevyDeferred | Self::Lean)
    }

    /// Adds the contender's components to `camera`.
    pub fn dress(self, preset: LeanPreset, camera: &mut EntityCommands) {
        self.renderer().prepare_camera(camera);
        if self.is_lean() {
            camera.insert((LeanMemory::default(), LeanForwardMeshes::default()));
        }
        if self == Self::LeanEffects {
            preset.apply(camera);
        }
    }
}
