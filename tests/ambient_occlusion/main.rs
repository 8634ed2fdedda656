//! Ambient occlusion: the shipped WGSL on the device against its Rust twin, errors against closed forms and the converged integral of the
//! same depth buffers, hard cases, occlusion in Bevy's pictures, and the ground truth itself.

mod accuracy;
mod edges;
mod horizon;
mod hostile;
mod lean;
mod motion;
mod near;
mod pictures;
mod projections;
mod reach;
mod shapes;
mod stage;
mod truth;
mod variants;
mod views;
