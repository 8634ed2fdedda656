//! A leaner renderer for any Bevy 3D camera, switched on by components.
//!
//! Add the plugins, and put [`LeanDeferred`] on a camera. It shows the picture of Bevy's forward renderer from a G-buffer half the
//! size of Bevy deferred's: 8 bytes a pixel beside depth, where that has 17.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_lean_deferred::prelude::*;
//!
//! App::new()
//!     .add_plugins((DefaultPlugins, LeanDeferredPlugins))
//!     .add_systems(Startup, |mut commands: Commands| {
//!         commands.spawn((Camera3d::default(), LeanDeferred::default()));
//!     })
//!     .run();
//! ```
//!
//! | component | effect | for |
//! |---|---|---|
//! | [`LeanDeferred`] | packed G-buffer, lighting in one compute pass | 3D cameras |
//! | [`LeanAmbientOcclusion`] | ambient occlusion from depth, without a prepass | 3D cameras |
//! | [`LeanScreenSpaceGi`] | diffuse light from one surface to another | cameras with [`LeanDeferred`] |
//! | [`LeanScreenSpaceReflections`] | reflections of the picture, smooth and rough | cameras with [`LeanDeferred`] |
//! | [`LeanSubsurfaceScattering`] | how light scatters beneath surfaces | cameras with [`LeanDeferred`] |
//! | [`LeanAutoExposure`] | exposure from the picture's luminance | 3D and 2D cameras; adds `Hdr` |
//! | [`CameraCut`] | the camera jumps: effects forget its last frame | all of these |
//!
//! Each can be added, changed and removed at run time; without it nothing is allocated, bound or run for it.
//! [`GBufferMaterial`](gbuffer::GBufferMaterial) takes custom materials into the G-buffer,
//! [`ShadingExtension`](shading_extension::ShadingExtension) adds shading models to `StandardMaterial`.
//!
//! # The frame of a camera with [`LeanDeferred`]
//!
//! 1. **G-buffer** ([`gbuffer`]): opaque and alpha-masked meshes are rasterised once, into two 32-bit targets and the
//!    view's depth. Those that need more (emission, clearcoat, motion, … : [`GBufferTargets`](gbuffer::GBufferTargets)) come
//!    after, in a pass with optional targets, which exist only while something visible writes them. What no target has bits
//!    for stays in Bevy's forward passes on the same camera.
//! 2. **Lighting** ([`lighting`]): one compute pass lights every pixel as Bevy's forward pass does and writes the view's HDR
//!    texture. Tiles with special surfaces have a dispatch of their own. What the view does not have (fog, probes, shadows,
//!    decals, …) is neither compiled in nor bound.
//! 3. Bevy goes on: forward-only opaque meshes, sky, transmissive and transparent meshes, post-processing.
//!
//! Occlusion, diffuse GI and reflections run between 1 and 2, subsurface scattering after 2, auto exposure after anti-aliasing
//! and before post-processing.
//!
//! # Which cameras
//!
//! A camera without these components renders as Bevy renders it. So does one whose settings or whose device lack what a component
//! needs; `docs/reliability.md` lists that for each component. One warning says why, and [`LeanStatus`] says it to the app of
//! cameras with [`LeanDeferred`]. `Hdr` and `Msaa::Off` are set when the component is added, and given back with it. While shaders
//! compile, in the first frames, Bevy renders the camera.
//!
//! # GPU times
//!
//! Each pass is recorded under `lean_deferred/…`; add Bevy's `RenderDiagnosticsPlugin` to read the times from its
//! `DiagnosticsStore`. Pipelines and textures have the same labels in graphics debuggers.
//! [`LeanDeferred::debug_view`] shows a channel of the G-buffer in place of the picture.

#![warn(missing_docs)]

extern crate alloc;

pub mod ambient_occlusion;
pub mod auto_exposure;
pub mod gbuffer;
mod gpu;
pub mod lean;
pub mod lighting;
mod named;
pub mod screen_space;
#[doc(hidden)]
pub mod shader_library;
pub mod shading_extension;
#[doc(hidden)]
pub mod shading_models;
pub mod view;

pub use ambient_occlusion::{LeanAmbientOcclusion, LeanAmbientOcclusionPlugin};
pub use auto_exposure::{LeanAutoExposure, LeanAutoExposurePlugin};
pub use lean::{LeanDeferredPlugin, LeanDeferredSupport};
pub use screen_space::{
    LeanScreenSpaceGi, LeanScreenSpaceGiPlugin, LeanScreenSpaceReflections,
    LeanScreenSpaceReflectionsPlugin, LeanSubsurfaceScattering,
};
pub use view::{
    CameraCut, DebugChannel, GeometricNormal, LeanDeferred, LeanOffReason, LeanStatus, LightCulling,
};

use bevy::app::plugin_group;

/// What most programs need.
pub mod prelude {
    pub use crate::{
        CameraCut, DebugChannel, GeometricNormal, LeanAmbientOcclusion, LeanAmbientOcclusionPlugin,
        LeanAutoExposure, LeanAutoExposurePlugin, LeanDeferred, LeanDeferredPlugin,
        LeanDeferredPlugins, LeanDeferredSupport, LeanOffReason, LeanScreenSpaceGi,
        LeanScreenSpaceGiPlugin, LeanScreenSpaceReflections, LeanScreenSpaceReflectionsPlugin,
        LeanStatus, LeanSubsurfaceScattering, LightCulling,
        ambient_occlusion::{
            OcclusionApplication, OcclusionFilter, OcclusionFormat, OcclusionKernel,
            OcclusionNormals, OcclusionQuality, OcclusionResolution,
        },
        auto_exposure::{
            ExposureClock, ExposureSampling, LuminanceTrim, MeteredExposure, Metering,
            MeteringPattern, ReductionPath,
        },
        gbuffer::{
            GBufferMaterial, GBufferMaterialExtension, GBufferMaterialPlugin, GBufferNeeds,
            GBufferTargets, GBufferUsage, ShadingModel,
        },
        screen_space::{
            ScreenSpaceGiDebugView, ScreenSpaceGiQuality, ScreenSpaceReflectionsDebugView,
            ScreenSpaceReflectionsQuality, ScreenSpaceResolution, SubsurfaceScatteringQuality,
        },
        shading_extension::{ExtendedStandardMaterial, ShadingExtension, SubsurfaceAlbedo},
    };
}

plugin_group! {
    /// All effects of this crate. Add it after `DefaultPlugins`. Each plugin can be added alone, too; diffuse GI and reflections do
    /// nothing without [`LeanDeferredPlugin`].
    pub struct LeanDeferredPlugins {
        :LeanDeferredPlugin,
        :LeanAmbientOcclusionPlugin,
        :LeanAutoExposurePlugin,
        :LeanScreenSpaceGiPlugin,
        :LeanScreenSpaceReflectionsPlugin,
    }
}
