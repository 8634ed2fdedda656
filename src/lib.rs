//! A leaner renderer for any Bevy 3D camera, switched on by components.
//!
//! Add the plugins, and put [`LeanDeferred`] on a camera. It renders the image of Bevy's forward renderer from a G-buffer half the
//! size of that of Bevy's deferred renderer: 8 bytes per pixel in addition to depth, instead of 17.
//!
#![cfg_attr(
    doc,
    doc = concat!(
        "<img alt=\"A street by night\" src=\"data:image/jpeg;base64,",
        include_str!("../docs/pictures/thumbs/showcase.jpg.base64"),
        "\">\n\n*Left: Bevy forward. Right: with diffuse GI, reflections and scattering of this crate.*"
    )
)]
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
//! | [`LeanScreenSpaceAmbientOcclusion`] | ambient occlusion from depth, without a prepass | 3D cameras |
//! | [`LeanScreenSpaceGi`] | screen-space diffuse global illumination | 3D cameras; adds [`LeanDeferred`] |
//! | [`LeanScreenSpaceReflections`] | screen-space reflections, smooth and rough | 3D cameras; adds [`LeanDeferred`] |
//! | [`LeanSubsurfaceScattering`] | light scatters beneath surfaces whose material asks for it | 3D cameras; adds [`LeanDeferred`] |
//! | [`LeanAutoExposure`] | exposure from the image's luminance | 3D and 2D cameras; adds `Hdr` |
//! | [`CameraCut`] | the camera jumps: effects drop their history | all of these |
//! | [`LeanPrewarm`] | pipelines are compiled during a loading screen | cameras with [`LeanDeferred`] |
//! | [`LeanDebugView`] | data of an effect in place of the image | all of these |
//!
//! Each can be added, changed and removed at run time; without it nothing is allocated, bound or dispatched for it.
//! [`GBufferMaterial`](gbuffer::GBufferMaterial) renders custom materials to the G-buffer,
//! [`ShadingExtension`](material_extension::ShadingExtension) adds shading models to `StandardMaterial`.
//!
//! # Settings
//!
//! Effects share the types of their levels: ambient occlusion, diffuse GI and reflections have a [`LeanQuality`] and a
//! [`LeanResolution`], scattering has a [`LeanQuality`], auto exposure has neither. Levels can be listed, written and read, for menus
//! and command lines, and with the feature `serialize` stored by serde. Settings that few games change are in the `advanced` field of
//! a component. [`LeanPreset`] sets which effects a camera has, and their levels, in one call. Bevy's `bsn!` spawns all components,
//! also with some of their fields alone.
//!
//! # The frame of a camera with [`LeanDeferred`]
//!
//! 1. **G-buffer** ([`gbuffer`]): opaque and alpha-masked meshes are rasterised once, into two 32-bit targets and the view's depth.
//!    Meshes that need more (emission, clearcoat, motion, … : [`GBufferTargets`](gbuffer::GBufferTargets)) follow in a pass with
//!    optional targets, which exist only while something visible writes them. Meshes that no target can represent stay in Bevy's
//!    forward passes on the same camera.
//! 2. **Lighting** ([`lighting`]): one compute pass lights every pixel as Bevy's forward pass does and writes the view's HDR
//!    texture. Tiles with special surfaces have a dispatch of their own. Features that the view does not use (fog, probes, shadows,
//!    decals, …) are neither compiled in nor bound. Until the pipeline for its features is compiled, a general one lights the view,
//!    which has all features compiled in and binds placeholders for those that the view lacks.
//! 3. **Bevy's passes**: forward-only opaque meshes, sky, transmissive and transparent meshes, post-processing. Those meshes of
//!    `StandardMaterial` are lit by the functions of step 2, with the exceptions in `docs/limits.md`.
//!
//! Occlusion, diffuse GI and reflections run between 1 and 2, subsurface scattering after 2, auto exposure after anti-aliasing
//! and before post-processing. The modules of [`effects`] describe their passes.
//!
//! # Supported cameras
//!
//! A camera without these components renders as Bevy renders it. So does one whose settings or device do not meet the requirements of
//! a component, listed in `docs/reliability.md`. One warning gives the reason and what to change. [`LeanStatus`], on each camera with
//! such a component, gives it to the app; [`LeanSupport`] tells what the device can run. `Hdr` and `Msaa::Off` are set when the
//! component is added, and restored when it is removed. Other cameras stay as they are: those that draw over such a camera or under it
//! need both too, and one warning names them. While pipelines compile, in the first frames, Bevy renders the camera
//! (`docs/compiling.md`).
//!
//! # GPU times
//!
//! Each pass is timed under `lean_deferred/…`; add Bevy's `RenderDiagnosticsPlugin` to read the times from its
//! `DiagnosticsStore`. Pipelines and textures have the same labels in graphics debuggers.
//! [`LeanDebugView`], inserted on a camera, shows the G-buffer or the result of an effect in place of the image; [`LeanMemory`] tells
//! the GPU memory of each effect.
//!
//! # FAQ
//!
//! Pages whose names begin with `docs/` are in the package: [docs.rs](https://docs.rs/crate/bevy_lean_deferred/latest/source/docs/) shows
//! them.
//!
//! **Should I use it?** Yes for many lights, for a camera that Bevy renders deferred or with a prepass, or for one of the effects. No for
//! a forward camera with few lights and no prepass, for MSAA, and for WebGL2. The README has a table of cases.
//!
//! **Does it work with …?** `docs/your_game.md` has a row for lightmaps, particles, outlines, UI, TAA, bloom, fog, split screen and so on,
//! with the test that shows it.
//!
//! **My camera is not lean, or an effect does nothing.** [`LeanStatus`] on the camera has the reason, which names what to change:
//! [`LeanOffReason`]. `docs/troubleshooting.md` lists symptoms, causes and fixes.
//!
//! **The image changed when I added [`LeanDeferred`].** It adds `Hdr`, which changes Bevy's own image. Insert `Hdr` without this crate,
//! and compare. If the images still differ, [`LeanDeferred::enabled`] switches between the two renderers.
//!
//! **Some meshes have no occlusion, GI or reflections.** Bevy's forward pass draws them. [`LeanForwardMeshes`](gbuffer::LeanForwardMeshes)
//! counts them by [`ForwardReason`](gbuffer::ForwardReason), and [`DebugView::Forward`] shows them.
//!
//! **How do my own materials get into the G-buffer?** By a [`GBufferMaterialPlugin`](gbuffer::GBufferMaterialPlugin) and a fragment shader
//! that packs a `PbrInput`: see [`GBufferMaterial`](gbuffer::GBufferMaterial).
//!
//! **Do the effects need TAA?** No: their patterns are the same in each frame. With TAA, which averages frames, they
//! rotate from frame to frame.
//!
//! **My camera jumps, and shows old light.** Insert [`CameraCut`] on it in that frame.
//!
//! **How do I switch it at run time?** Insert and remove components, or apply a [`LeanPreset`]. Spawn the camera with `Hdr` and `Msaa::Off`,
//! so that no pipeline has to change its format.
//!
//! **Which devices does it need?** [`LeanSupport`] has the answer before any camera is spawned. WebGPU's default limits suffice for all but
//! scattering, decals, textures of lights and several environment maps.

#![warn(missing_docs)]

extern crate alloc;

pub mod activation;
pub mod effects;
pub mod gbuffer;
mod gpu;
pub mod lighting;
pub mod material_extension;
mod preset;
#[doc(hidden)]
pub mod shader_library;
#[doc(hidden)]
pub mod shading_models;
pub mod view;

pub use activation::LeanDeferredPlugin;
pub use effects::{
    LeanScreenSpaceGi, LeanScreenSpaceGiPlugin, LeanScreenSpaceReflections,
    LeanScreenSpaceReflectionsPlugin, LeanSubsurfaceScattering, LeanSubsurfaceScatteringPlugin,
    ambient_occlusion::{LeanScreenSpaceAmbientOcclusion, LeanScreenSpaceAmbientOcclusionPlugin},
    auto_exposure::{LeanAutoExposure, LeanAutoExposurePlugin},
};
pub use preset::LeanPreset;
pub use view::{
    CameraCut, DebugView, EffectStatus, LeanDebugView, LeanDeferred, LeanMemory, LeanOffReason,
    LeanPrewarm, LeanQuality, LeanResolution, LeanStatus, LeanSupport, LightCulling,
    PrewarmFeatures, PrewarmProgress,
};

use bevy::app::plugin_group;

/// The code of pages, which is compiled as tests of the documentation.
#[cfg(doctest)]
mod pages {
    #[doc = include_str!("../README.md")]
    struct Readme;
    #[doc = include_str!("../docs/ambient_occlusion.md")]
    struct AmbientOcclusion;
    #[doc = include_str!("../docs/auto_exposure.md")]
    struct AutoExposure;
    #[doc = include_str!("../docs/compiling.md")]
    struct Compiling;
    #[doc = include_str!("../docs/diffuse_gi.md")]
    struct DiffuseGi;
    #[doc = include_str!("../docs/migration.md")]
    struct Migration;
    #[doc = include_str!("../docs/presets.md")]
    struct Presets;
    #[doc = include_str!("../docs/profiling.md")]
    struct Profiling;
    #[doc = include_str!("../docs/reflections.md")]
    struct Reflections;
    #[doc = include_str!("../docs/subsurface_scattering.md")]
    struct SubsurfaceScattering;
}

/// The plugins, the components of cameras with their levels and reports, and materials. All else is at the root of the crate
/// ([`LeanPrewarm`], [`LightCulling`], single plugins) or in its module: parts of settings, such as
/// [`OcclusionFilter`](crate::effects::ambient_occlusion::OcclusionFilter), and [`ForwardReason`](crate::gbuffer::ForwardReason).
pub mod prelude {
    pub use crate::{
        CameraCut, DebugView, EffectStatus, LeanAutoExposure, LeanDebugView, LeanDeferred,
        LeanDeferredPlugins, LeanMemory, LeanOffReason, LeanPreset, LeanQuality, LeanResolution,
        LeanScreenSpaceAmbientOcclusion, LeanScreenSpaceGi, LeanScreenSpaceReflections, LeanStatus,
        LeanSubsurfaceScattering, LeanSupport,
        effects::auto_exposure::MeteredExposure,
        gbuffer::{GBufferMaterial, GBufferMaterialPlugin, GBufferNeeds, LeanForwardMeshes},
        material_extension::{ExtendedStandardMaterial, ShadingExtension},
    };
}

plugin_group! {
    /// All effects of this crate. Add it after `DefaultPlugins`. Each plugin can also be added alone; diffuse GI, reflections,
    /// subsurface scattering and shading extensions need [`LeanDeferredPlugin`].
    pub struct LeanDeferredPlugins {
        :LeanDeferredPlugin,
        material_extension:::ShadingExtensionPlugin,
        :LeanScreenSpaceAmbientOcclusionPlugin,
        :LeanAutoExposurePlugin,
        :LeanScreenSpaceGiPlugin,
        :LeanScreenSpaceReflectionsPlugin,
        :LeanSubsurfaceScatteringPlugin,
    }
}
