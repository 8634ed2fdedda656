//! Ambient occlusion: the shipped WGSL on the device beside its Rust twin, its errors against closed forms and against
//! the converged integral of the same depth buffer, hard cases, and how it reaches Bevy's pictures.

mod common;
#[path = "ambient_occlusion/horizon.rs"]
mod horizon;
