//! A leaner renderer for any Bevy 3D camera, switched on by components.
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
//! # The frame of a camera with [`LeanDeferred`]
//!
//! 1. **G-buffer** ([`gbuffer`]): opaque and alpha-masked meshes are rasterised once, into two 32-bit targets and the
//!    view's depth: 8 bytes a pixel beside depth. Those that need more (emission, clearcoat, motion, … :
//!    [`GBufferTargets`](gbuffer::GBufferTargets)) come after, in a pass with optional targets, which exist only while
//!    something visible writes them. What no target has bits for
//!    ([`GBufferMaterial`](gbuffer::GBufferMaterial)) stays in Bevy's forward passes on the same camera.
//! 2. **Lighting** ([`lighting`]): one compute pass lights every pixel as Bevy's forward pass does and writes the view's HDR
//!    texture. Tiles with special surfaces have a dispatch of their own. Where there are many lights, those that cannot reach a
//!    tile are left out for all of it ([`LightCulling`]). What the view does not have (fog, probes, shadows, decals, …) is
//!    neither compiled in nor bound.
//! 3. Bevy goes on: forward-only opaque meshes, sky, transmissive and transparent meshes, post-processing.
//!
//! Any camera may have [`LeanAmbientOcclusion`]: in the lighting pass of lean ones, multiplied onto the picture of others. And any
//! HDR camera [`LeanAutoExposure`], between anti-aliasing and post-processing. Lean ones may have [`LeanScreenSpaceGi`]: light
//! that surfaces send to one another, and [`LeanScreenSpaceReflections`]: what they mirror, both found between G-buffer and
//! lighting. After it light scatters beneath surfaces that let it in ([`LeanSubsurfaceScattering`]).
//!
//! Data flows one way: component ([`view`]) → extract → the decision which views are lean ([`lean`]) → queue and prepare →
//! bind → pass. The GPU time of each pass is recorded under `lean_deferred/…`, visible with Bevy's
//! `RenderDiagnosticsPlugin`.
//!
//! A camera without [`LeanDeferred`] renders as Bevy renders it. So does one that cannot be rendered lean (MSAA, no HDR, a
//! device that lacks something), after one warning that says why; [`LeanStatus`] says it too.

#![warn(missing_docs)]

extern crate alloc;

pub mod ambient_occlusion;
pub mod auto_exposure;
pub mod gbuffer;
mod gpu;
pub mod lean;
pub mod lighting;
pub mod screen_space;
#[doc(hidden)]
pub mod shader_library;
pub mod shading_extension;
#[doc(hidden)]
pub mod shading_models;
pub mod view;

pub use ambient_occlusion::{LeanAmbientOcclusion, LeanAmbientOcclusionPlugin};
pub use auto_exposure::{LeanAutoExposure, LeanAutoExposurePlugin};
pub use lean::LeanDeferredPlugin;
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
        LeanDeferredPlugins, LeanOffReason, LeanScreenSpaceGi, LeanScreenSpaceGiPlugin,
        LeanScreenSpaceReflections, LeanScreenSpaceReflectionsPlugin, LeanStatus,
        LeanSubsurfaceScattering, LightCulling,
        ambient_occlusion::{
            OcclusionApplication, OcclusionFilter, OcclusionFormat, OcclusionKernel,
            OcclusionNormals, OcclusionQuality, OcclusionResolution,
        },
        auto_exposure::{
            ExposureSampling, LuminanceTrim, MeteredExposure, Metering, MeteringPattern,
            ReductionPath,
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
    /// All effects of this crate; each is a plugin that works without the others. Add it after `DefaultPlugins`.
    pub struct LeanDeferredPlugins {
        :LeanDeferredPlugin,
        :LeanAmbientOcclusionPlugin,
        :LeanAutoExposurePlugin,
        :LeanScreenSpaceGiPlugin,
        :LeanScreenSpaceReflectionsPlugin,
    }
}
