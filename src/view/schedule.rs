//! System sets for the stages of a frame.

use bevy::prelude::*;

/// The systems that decide which views are rendered lean; in `RenderSystems::PrepareAssets`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct LeanViewSystems;

/// The systems that allocate the textures of views; after `RenderSystems::PrepareViews` and before
/// `RenderSystems::Queue`, so that a lean camera whose textures do not fit into memory is left to Bevy before its
/// meshes are queued.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct ViewTextureSystems;

/// The last system that queues meshes of lean views for Bevy's passes; in `RenderSystems::QueueMeshes`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct ForwardMeshesQueued;

/// The passes that draw the G-buffer, in `Core3d`. They run after all other systems before `Core3dSystems::MainPass`,
/// which may have drawn colour and depth. Systems that are ordered after Bevy's prepass run later and see lean meshes
/// in it.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct GBufferPasses;

/// The passes that light the G-buffer, in `Core3d`. They run before all other systems that are not ordered before them:
/// a renderer that draws colour and depth before Bevy's opaque pass draws among lit meshes. Order a system that
/// prepares data for lighting before this set.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct LightingPasses;

/// The passes that change or read the picture right after opaque meshes, in `Core3d`. They run before all others that
/// follow Bevy's opaque pass, such as that of its atmosphere.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct OpaquePicturePasses;

/// Effects that compute indirect light or occlusion from the G-buffer, before lighting reads it, in `Core3d`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct IndirectLightPasses;

/// Keeps the frame as history for the next one: after all other systems of `Core3dSystems::MainPass` that are not
/// ordered after it.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct HistoryPasses;

/// Draws debug views of screen-space effects, in `Core3d`, after the history is kept.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct DebugViewPasses;

/// Meters the picture, after all systems before post-processing, in `Core3d` and `Core2d`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct ExposurePasses;

/// Draws over the picture after all other systems of post-processing, in `Core3d` and `Core2d`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct ExposureOverlayPasses;
