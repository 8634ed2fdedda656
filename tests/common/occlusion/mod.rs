//! Ground truth for ambient occlusion: what a renderer should find, without a renderer.
//!
//! Occlusion is 1 − visibility, weighted by the cosine over the hemisphere about the surface normal. A radius R is the
//! length past which nothing occludes, and may be infinite. Lengths are in metres, angles in radians, all in f64.

pub mod closed_forms;
