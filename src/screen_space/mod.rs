//! What effects read of the screen beside the surfaces of this frame.
//!
//! - `history.rs`: the last frame of a view, for those that ask for it.

mod history;

// Effects of the next kind will ask; until then tests do.
pub(crate) use history::HistoryPlugin;
#[doc(hidden)]
pub use history::{LastFrame, ReadsHistory, ViewHistory};
