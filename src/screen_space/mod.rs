//! What effects find on the screen: in the surfaces of this frame, and in the light of the last one.
//!
//! - `succession.rs`: which frames of a view follow one another. `history.rs`: the last frame of a view, for those that ask
//!   for it.
//! - `diffuse_gi/`: light that surfaces send to one another.

pub mod diffuse_gi;
mod history;
mod succession;

pub use diffuse_gi::{
    LeanScreenSpaceGi, LeanScreenSpaceGiPlugin, ScreenSpaceGiQuality, ScreenSpaceGiResolution,
};
pub(crate) use history::HistoryPlugin;
// Effects of the next kind will ask; until then tests do.
#[doc(hidden)]
pub use {
    history::{ReadsHistory, ViewHistory},
    succession::LastFrame,
};
