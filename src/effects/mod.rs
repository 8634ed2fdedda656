//! The effects of cameras. Each has a module of its own.
//!
//! | component | computes | reads the last frame |
//! |---|---|---|
//! | [`LeanScreenSpaceAmbientOcclusion`] | ambient light that near surfaces block | no |
//! | [`LeanScreenSpaceGi`] | diffuse light between surfaces | yes |
//! | [`LeanScreenSpaceReflections`] | reflections of the picture | yes |
//! | [`LeanSubsurfaceScattering`] | light that leaves a surface away from where it entered | no |
//! | [`LeanAutoExposure`] | exposure from the luminance of the picture | its exposure alone |
//!
//! Global illumination, reflections and scattering are for cameras with [`LeanDeferred`](crate::LeanDeferred). They carry light over
//! the surfaces of this frame, with the light of this frame or of the last one. Lighting blends the first two with environment maps,
//! probes and ambient light, which they replace in part. Only surfaces in the picture contribute. The last frame is invalid after a
//! [`CameraCut`](crate::CameraCut), a pause, or a change between perspective and orthographic. With `MotionVectorPrepass` on the
//! camera, moving surfaces are reprojected along their motion; without it, their light lags one frame behind, and surfaces that move
//! with the camera, such as a weapon, are looked for in place. If an app shifts its whole world, all meshes and cameras alike, nothing
//! counts as moved.
//!
//! [`LeanScreenSpaceAmbientOcclusion`]: ambient_occlusion::LeanScreenSpaceAmbientOcclusion
//! [`LeanAutoExposure`]: auto_exposure::LeanAutoExposure

// - `ambient_occlusion/`: ambient occlusion from depth.
// - `auto_exposure/`: exposure from the picture.
// - `history_validity.rs`: detects if the last frame of a view directly precedes this one.
// - `reprojection.{rs,wgsl}`: transforms into the last frame, and the weight with which surfaces are those that it showed.
// - `world_shift.rs`: detects shifts of the whole world.
// - `support.rs`: limits that GI, reflections and scattering need.
// - `history/`: light and depth of the last frame, for effects that request them.
// - `diffuse_gi/`: diffuse light between surfaces.
// - `reflections/`: reflections.
// - `subsurface/`: subsurface scattering.
// - `debug_view/`: shows textures of GI and reflections in place of the picture.
// - `resolution.rs`: sizes of textures.
// - `shown_exposure.{rs,wgsl}`: the exposure that tonemapping applied to the last frame.

pub mod ambient_occlusion;
pub mod auto_exposure;
#[doc(hidden)]
pub mod debug_view;
pub mod diffuse_gi;
#[doc(hidden)]
pub mod history;
mod history_validity;
pub mod reflections;
mod reprojection;
mod resolution;
mod shown_exposure;
pub mod subsurface;
mod support;
mod world_shift;

#[doc(hidden)]
pub use crate::view::DebugViewPasses;
pub use diffuse_gi::{LeanScreenSpaceGi, LeanScreenSpaceGiAdvanced, LeanScreenSpaceGiPlugin};
#[doc(hidden)]
pub use history::{ReadsHistory, ViewHistory};
pub use reflections::{
    LeanScreenSpaceReflections, LeanScreenSpaceReflectionsAdvanced,
    LeanScreenSpaceReflectionsPlugin,
};
pub use subsurface::{
    LeanSubsurfaceScattering, LeanSubsurfaceScatteringAdvanced, LeanSubsurfaceScatteringPlugin,
};
#[doc(hidden)]
pub use {history_validity::LastFrame, support::NEEDED_LIMITS};

#[cfg(feature = "test_hooks")]
pub use crate::gpu::timed::TimesEachDispatch;
