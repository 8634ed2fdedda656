//! Reconstructs the position, the normal and the motion at rest of a surface from depth. Each WGSL module has a Rust twin for tests
//! and measurements; `position.rs` also has helpers for projections.

pub mod motion;
pub mod normal;
pub mod position;
