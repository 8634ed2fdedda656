//! Ground truth for ambient occlusion, computed without a renderer.
//!
//! Occlusion is 1 − visibility, weighted by the cosine over the hemisphere about the surface normal. Nothing occludes beyond a radius R,
//! which may be infinite. Lengths are in metres, angles in radians, all in f64.
//!
//! - [`closed_forms`]: exact occlusion of simple geometry.
//! - [`geometry`]: scenes made of that geometry, with rays and closed forms in world space.
//! - [`camera`]: Bevy's projections.
//! - [`depth_buffer`]: depth buffers of a scene, rounded as a depth attachment rounds, and the truth per pixel.
//! - [`integrator`]: the converged screen-space integral of a depth buffer.
//! - [`errors`]: error statistics of a result.
//!
//! A result minus the closed form is its total error. A result minus the integral is the error of its sampling, precision and filter; the
//! integral minus the closed form is the error of what the depth buffer does not hold.

pub mod camera;
pub mod closed_forms;
pub mod depth_buffer;
pub mod errors;
pub mod geometry;
pub mod integrator;
pub mod solids;
