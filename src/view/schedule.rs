//! When the stages of a frame run.

use bevy::prelude::*;

/// The systems that decide which views are rendered lean; in `RenderSystems::PrepareAssets`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct LeanViewSystems;

/// The passes that draw the G-buffer, in `Core3d`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct GBufferPasses;

/// The passes that light it, in `Core3d`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct LightingPasses;
