//! The contenders.

use bevy::{core_pipeline::prepass::DepthPrepass, prelude::*};
use bevy_lean_deferred::prelude::*;
use kit::renderer::Renderer;

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    Forward,
    /// Bevy forward after a depth prepass.
    ForwardPrepass,
    BevyDeferred,
    Lean,
    /// Lean, with alpha-masked meshes drawn once.
    LeanOneDraw,
    LeanOcclusion,
    LeanGi,
    LeanReflections,
    /// Lean with the effects of a preset.
    LeanEffects,
}

impl Contender {
    /// Forward first: it is the reference of the others.
    pub const ALL: [Self; 9] = [
        Self::Forward,
        Self::ForwardPrepass,
        Self::BevyDeferred,
        Self::Lean,
        Self::LeanOneDraw,
        Self::LeanOcclusion,
        Self::LeanGi,
        Self::LeanReflections,
        Self::LeanEffects,
    ];

    /// Those of `names`, comma-separated, in the order of [`Self::ALL`]; `all` stands for all of them.
    pub fn named(names: &str) -> Result<Vec<Self>, String> {
        let names: Vec<&str> = names.split(',').map(str::trim).collect();
        let known = Self::ALL.map(Self::name);
        if let Some(wrong) = names.iter().find(|n| **n != "all" && !known.contains(n)) {
            let known = known.join(", ");
            return Err(format!("no contender {wrong:?}: expected all, {known}"));
        }
        let is_named = |own: &Self| names.contains(&"all") || names.contains(&own.name());
        Ok(Self::ALL.into_iter().filter(is_named).collect())
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::ForwardPrepass => "Bevy forward with prepass",
            Self::LeanOneDraw => "lean without depth of masks",
            Self::LeanOcclusion => "lean with occlusion",
            Self::LeanGi => "lean with GI",
            Self::LeanReflections => "lean with reflections",
            Self::LeanEffects => "lean with effects",
            _ => self.renderer().name(),
        }
    }

    pub fn renderer(self) -> Renderer {
        match self {
            Self::Forward | Self::ForwardPrepass => Renderer::Forward,
            Self::BevyDeferred => Renderer::BevyDeferred,
            _ => Renderer::Lean,
        }
    }

    pub fn is_lean(self) -> bool {
        self.renderer() == Renderer::Lean
    }

    /// Tells if it is measured without being named.
    pub fn is_default(self) -> bool {
        matches!(
            self,
            Self::Forward | Self::BevyDeferred | Self::Lean | Self::LeanEffects
        )
    }

    /// Tells if its picture is to be forward's.
    pub fn is_compared(self) -> bool {
        matches!(
            self,
            Self::ForwardPrepass | Self::BevyDeferred | Self::Lean | Self::LeanOneDraw
        )
    }

    /// Adds the contender's components to `camera`.
    pub fn dress(self, preset: LeanPreset, camera: &mut EntityCommands) {
        self.renderer().prepare_camera(camera);
        if self.is_lean() {
            camera.insert((LeanMemory::default(), LeanForwardMeshes::default()));
        }
        match self {
            Self::ForwardPrepass => {
                camera.insert(DepthPrepass);
            }
            Self::LeanOcclusion => {
                camera.insert(LeanScreenSpaceAmbientOcclusion::default());
            }
            Self::LeanGi => {
                camera.insert(LeanScreenSpaceGi::default());
            }
            Self::LeanReflections => {
                camera.insert(LeanScreenSpaceReflections::default());
            }
            Self::LeanEffects => preset.apply(camera),
            Self::Forward | Self::BevyDeferred | Self::Lean | Self::LeanOneDraw => {}
        }
    }
}
