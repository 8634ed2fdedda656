//! Levels: glTF files with lights, lightmaps and views. For the bench `levels`, and for tests.
//!
//! `docs/levels.md` has the conventions for the files beside a glTF file.

mod file;
mod framing;
mod lightmaps;
mod lights;
mod loading;
mod room;

pub use file::{Level, View, evenly_spread, read_views};
pub use framing::framing_view;
pub use loading::LoadedLevel;
pub use room::write_room;
