//! Effects that find light on the screen: in the surfaces of this frame, and in the light of the last one.
//!
//! | component | finds | reads the last frame |
//! |---|---|---|
//! | [`LeanScreenSpaceGi`] | diffuse light that surfaces send to one another | yes |
//! | [`LeanScreenSpaceReflections`] | what surfaces mirror | yes |
//! | [`LeanSubsurfaceScattering`] | where light leaves that entered a surface elsewhere | no |
//!
//! All are for cameras with [`LeanDeferred`](crate::LeanDeferred). Lighting mixes the first two with environment maps, probes and ambient
//! light, in whose place they are seen. They know only what the picture shows. The last frame does not count after a
//! [`CameraCut`](crate::CameraCut), a pause, or a change of size or of the kind of projection. With `MotionVectorPrepass` on the camera they find
//! what moves where it was; without, its light is a frame behind it. Where an app shifts its world, with all meshes and cameras in it, nothing
//! has moved.

// - `succession.rs`: which frames of a view follow one another. `reprojection.rs`: where the last one had what this one shows.
//   `world_shift.rs`: shifts of all there is, which are no movement.
// - `support.rs`: what they need beside a camera that can be lean.
// - `history/`: the last frame of a view, for those that ask for it.
// - `diffuse_gi/`: light that surfaces send to one another. `reflections/`: what they mirror.
// - `subsurface/`: light that scatters beneath surfaces.
// - `debug_view/`: what an effect has found, in place of the picture.
// - `resolution.rs`: how many pixels share what effects find. `shown_exposure.{rs,wgsl}`: what shows as white.

#[doc(hidden)]
pub mod debug_view;
pub mod diffuse_gi;
#[doc(hidden)]
pub mod history;
pub mod reflections;
mod reprojection;
mod resolution;
mod shown_exposure;
pub mod subsurface;
mod succession;
mod support;
mod world_shift;

#[doc(hidden)]
pub use crate::view::DebugViewPasses;
pub use diffuse_gi::{
    LeanScreenSpaceGi, LeanScreenSpaceGiPlugin, ScreenSpaceGiDebugView, ScreenSpaceGiQuality,
};
#[doc(hidden)]
pub use history::{ReadsHistory, ViewHistory};
pub use reflections::{
    LeanScreenSpaceReflections, LeanScreenSpaceReflectionsPlugin, ScreenSpaceReflectionsDebugView,
    ScreenSpaceReflectionsQuality,
};
pub use resolution::ScreenSpaceResolution;
pub use subsurface::{LeanSubsurfaceScattering, SubsurfaceScatteringQuality};
#[doc(hidden)]
pub use {succession::LastFrame, support::NEEDED_LIMITS};

pub use crate::gpu::timed::TimesEachDispatch;
