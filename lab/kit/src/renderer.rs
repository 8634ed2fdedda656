//! The renderers under comparison.

use core::str::FromStr;

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    prelude::*,
};
use bevy_lean_deferred::prelude::*;

use crate::bench_spans;

/// A renderer in its default configuration.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Renderer {
    Forward,
    BevyDeferred,
    Lean,
}

impl FromStr for Renderer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "forward" => Ok(Self::Forward),
            "deferred" => Ok(Self::BevyDeferred),
            "lean" => Ok(Self::Lean),
            _ => Err("expected forward, deferred or lean".into()),
        }
    }
}

impl Renderer {
    /// Forward comes first: it is the reference.
    pub const ALL: [Self; 3] = [Self::Forward, Self::BevyDeferred, Self::Lean];

    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "Bevy forward",
            Self::BevyDeferred => "Bevy deferred",
            Self::Lean => "lean",
        }
    }

    /// Gives a camera the components that this renderer needs and removes those of others.
    /// [`OpaqueMethod`](crate::example::opaque_method::OpaqueMethod) switches materials.
    /// [`RenderersPlugin`](crate::example::renderers::RenderersPlugin) does both, and keeps the settings of `LeanDeferred`.
    pub fn prepare_camera(self, camera: &mut EntityCommands) {
        camera.remove::<(LeanDeferred, DepthPrepass, DeferredPrepass)>();
        match self {
            Self::Forward => {}
            Self::BevyDeferred => {
                camera.insert((DepthPrepass, DeferredPrepass));
            }
            Self::Lean => {
                camera.insert(LeanDeferred::default());
            }
        }
    }

    /// Bytes per pixel that geometry must write, and that geometry and lighting must move in all: each target is written once and read
    /// once, in the declared formats (depth 4, HDR colour 8). `gbuffer` is the size of a lean camera's.
    pub fn bytes_per_pixel(self, gbuffer: u32) -> (u32, u32) {
        match self {
            Self::Forward => (8 + 4, 8 + 4),
            // G-buffer 16, lighting id 1, depth 4; copies of the id (1 read, 2 written) and of depth (4 + 4);
            // lighting reads 16 + 2 + 4 and writes 8.
            Self::BevyDeferred => (16 + 1 + 4, 21 + 3 + 8 + 22 + 8),
            // G-buffer, depth 4; lighting reads both and writes 8. Optional targets count as if all pixels wrote them.
            Self::Lean => (gbuffer + 4, 2 * (gbuffer + 4) + 8),
        }
    }

    /// Names of the GPU spans of geometry and of lighting, with [`bench_spans::add_bench_spans`].
    pub fn spans(self) -> (&'static str, Option<&'static str>) {
        match self {
            Self::Forward => (bench_spans::OPAQUE, None),
            Self::BevyDeferred => (bench_spans::PREPASS, Some(bench_spans::DEFERRED_LIGHTING)),
            Self::Lean => ("lean_deferred/gbuffer", Some("lean_deferred/lighting")),
        }
    }
}
