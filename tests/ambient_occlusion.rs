//! Ambient occlusion: the shipped WGSL on the device beside its Rust twin, its errors against closed forms and against
//! the converged integral of the same depth buffer, hard cases, and how it reaches Bevy's pictures.

mod common;

#[path = "ambient_occlusion/accuracy.rs"]
mod accuracy;
#[path = "ambient_occlusion/edges.rs"]
mod edges;
#[path = "ambient_occlusion/horizon.rs"]
mod horizon;
#[path = "ambient_occlusion/hostile.rs"]
mod hostile;
#[path = "ambient_occlusion/lean.rs"]
mod lean;
#[path = "ambient_occlusion/motion.rs"]
mod motion;
#[path = "ambient_occlusion/pictures.rs"]
mod pictures;
#[path = "ambient_occlusion/projections.rs"]
mod projections;
#[path = "ambient_occlusion/reach.rs"]
mod reach;
#[path = "ambient_occlusion/shapes.rs"]
mod shapes;
#[path = "ambient_occlusion/stage.rs"]
mod stage;
#[path = "ambient_occlusion/variants.rs"]
mod variants;
#[path = "ambient_occlusion/views.rs"]
mod views;
