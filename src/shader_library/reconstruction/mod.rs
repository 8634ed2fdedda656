//! Reconstructs the position, the normal and the motion at rest of a surface from depth.

pub mod position;
