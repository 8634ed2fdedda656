//! What is drawn into the G-buffer, when, and with which targets.
//!
//! Each test has a process of its own: together they would take more memory than many a machine has, see
//! `kit/src/own_process.rs`.

mod geometry;
mod motion_vectors;
mod occlusion_culling;
mod optional_targets;
mod sorting;
