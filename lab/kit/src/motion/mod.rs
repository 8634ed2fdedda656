//! Scenes in motion: paths of a camera and of things, the yard that they cross, and figures of films of it.

pub mod film;
pub mod paths;
pub mod yard;
