//! Ambient occlusion: the shipped WGSL on the device beside its Rust twin, its errors against closed forms and against
//! the converged integral of the same depth buffer, hard cases, how it reaches Bevy's pictures, and the ground truth itself.

mod accuracy;
mod edges;
mod horizon;
mod hostile;
mod lean;
mod motion;
mod pictures;
mod projections;
mod reach;
mod shapes;
mod stage;
mod truth;
mod variants;
mod views;
