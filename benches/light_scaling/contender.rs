//! The contenders.

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
};
use bevy_lean_deferred::{LightCulling, prelude::*, view::LeanDeferredAdvanced};
use kit::bench_spans;

/// A way to render the scene.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    Forward,
    BevyDeferred,
    Lean(LightCulling),
}

impl Contender {
    /// Forward first: its pictures are the reference of the others.
    pub const ALL: [Self; 6] = [
        Self::Forward,
        Self::BevyDeferred,
        Self::Lean(LightCulling::Auto),
        Self::Lean(LightCulling::PerPixel),
        Self::Lean(LightCulling::Subgroup),
        Self::Lean(LightCulling::SharedMemory),
    ];

    /// Number of contenders that are measured by default: the first ones.
    pub const BY_DEFAULT: usize = 3;

    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "Bevy forward",
            Self::BevyDeferred => "Bevy deferred",
            Self::Lean(LightCulling::Auto) => "lean",
            Self::Lean(LightCulling::PerPixel) => "lean per pixel",
            Self::Lean(LightCulling::Subgroup) => "lean culling by subgroups",
            Self::Lean(LightCulling::SharedMemory) => "lean culling in shared memory",
        }
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.name() == name)
    }

    /// Position in [`ALL`](Self::ALL).
    pub fn index(self) -> usize {
        Self::ALL
            .iter()
            .position(|c| *c == self)
            .expect("all are listed")
    }

    /// The GPU span of the stage whose cost depends on the lights.
    pub fn span(self) -> &'static str {
        match self {
            Self::Forward => bench_spans::OPAQUE,
            Self::BevyDeferred => bench_spans::DEFERRED_LIGHTING,
            Self::Lean(_) => "lean_deferred/lighting",
        }
    }

    pub fn prepare_app(self, app: &mut App) {
        if self == Self::BevyDeferred {
            app.insert_resource(DefaultOpaqueRendererMethod::deferred());
        }
    }

    pub fn prepare_camera(self, camera: &mut EntityWorldMut) {
        match self {
            Self::Forward => {}
            Self::BevyDeferred => {
                camera.insert((DepthPrepass, DeferredPrepass));
            }
            Self::Lean(light_culling) => {
                camera.insert(LeanDeferred {
                    advanced: LeanDeferredAdvanced {
                        light_culling,
                        ..default()
                    },
                    ..default()
                });
            }
        }
    }
}
