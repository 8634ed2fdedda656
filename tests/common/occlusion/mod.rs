//! Ground truth for ambient occlusion: what a renderer should find, without a renderer.
//!
//! Occlusion is 1 − visibility, weighted by the cosine over the hemisphere about the surface normal. A radius R is the
//! length past which nothing occludes, and may be infinite. Lengths are in metres, angles in radians, all in f64.
//!
//! - [`closed_forms`]: exact occlusion of simple geometry.
//! - [`geometry`]: scenes made of that geometry, with rays and closed forms in world space.
//! - [`camera`]: Bevy's projections.
//! - [`depth_buffer`]: what a camera sees of a scene, rounded as a depth attachment rounds, and the truth per pixel.

pub mod camera;
pub mod closed_forms;
pub mod depth_buffer;
pub mod geometry;
pub mod solids;
