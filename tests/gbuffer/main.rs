//! Drawing into the G-buffer: geometry, motion vectors, culling, sorting, optional targets, and what forward draws.
//!
//! Each test has a process of its own: together they would exceed the memory of many machines, see `lab/kit/src/own_process.rs`.

mod bevys_pipelines;
mod forward_reasons;
mod geometry;
mod masked_depth;
mod motion_vectors;
mod occlusion_culling;
mod optional_targets;
mod pipelines;
mod sorting;
