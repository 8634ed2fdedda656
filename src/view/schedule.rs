//! When the stages of a frame run.

use bevy::prelude::*;

/// The systems that decide which views are rendered lean; in `RenderSystems::PrepareAssets`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct LeanViewSystems;

/// The systems that make the textures of views; after `RenderSystems::PrepareViews`, before `RenderSystems::Queue`: a lean camera whose
/// textures do not fit into memory is left to Bevy before its meshes are queued.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct ViewTextureSystems;

/// The passes that draw the G-buffer, in `Core3d`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct GBufferPasses;

/// The passes that light it, in `Core3d`. They run before all other systems of `Core3dSystems::MainPass` that are not asked to run before
/// them: a renderer that draws colour and depth before Bevy's opaque pass comes after them there. One that is in no set must be, too, or
/// before [`GBufferPasses`]. What prepares anything that lighting reads must be asked to run before.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct LightingPasses;

/// The passes that change or read the picture as opaque meshes left it, in `Core3d`. They run before all others that follow Bevy's opaque
/// pass, such as that of its atmosphere.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct OpaquePicturePasses;
