//! When the stages of a frame run.

use bevy::prelude::*;

/// The systems that decide which views are rendered lean; in `RenderSystems::PrepareAssets`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct LeanViewSystems;

/// The systems that make the textures of views; after `RenderSystems::PrepareViews`, before `RenderSystems::Queue`: a lean camera whose
/// textures do not fit into memory is left to Bevy before its meshes are queued.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct ViewTextureSystems;

/// The passes that draw the G-buffer, in `Core3d`. They run after all other systems that precede `Core3dSystems::MainPass`, and may have drawn
/// colour and depth, but for those asked to run after Bevy's prepass: these find lean meshes in it.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct GBufferPasses;

/// The passes that light it, in `Core3d`. They run before all other systems that may run after them: a renderer that draws colour and depth
/// before Bevy's opaque pass draws among lit meshes. A system that prepares data for lighting must be asked to run before.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct LightingPasses;

/// The passes that change or read the picture as opaque meshes left it, in `Core3d`. They run before all others that follow Bevy's opaque
/// pass, such as that of its atmosphere.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct OpaquePicturePasses;

/// Effects that find light or occlusion in the G-buffer, before lighting reads it, in `Core3d`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct FoundLightPasses;

/// Keeps the frame for effects that read it in the next one: after all other systems of `Core3dSystems::MainPass` that are not asked to run
/// after it.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct HistoryPasses;

/// Draws debug views of screen-space effects, in `Core3d`, once the frame is kept.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct DebugViewPasses;

/// Meters the picture: after what precedes post-processing, in `Core3d` and `Core2d`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct ExposurePasses;

/// Draws over the picture after all other systems of post-processing, in `Core3d` and `Core2d`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct ExposureOverlayPasses;
