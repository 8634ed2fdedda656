//! What effects find on the screen: in the surfaces of this frame, and in the light of the last one.
//!
//! - `succession.rs`: which frames of a view follow one another. `reprojection.rs`: where the last one had what this one shows.
//! - `history/`: the last frame of a view, for those that ask for it.
//! - `diffuse_gi/`: light that surfaces send to one another. `reflections/`: what they mirror.
//! - `subsurface/`: light that scatters beneath surfaces.
//! - `debug_view/`: what an effect has found, in place of the picture.
//! - `resolution.rs`: how many pixels share what effects find. `pattern.rs`: how the directions in which they look turn.

#[doc(hidden)]
pub mod debug_view;
pub mod diffuse_gi;
#[doc(hidden)]
pub mod history;
mod pattern;
pub mod reflections;
mod reprojection;
mod resolution;
pub mod subsurface;
mod succession;

#[doc(hidden)]
pub use debug_view::DebugViewPasses;
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
pub use succession::LastFrame;
