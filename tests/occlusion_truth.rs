//! The ground truth for ambient occlusion holds: closed forms beside Monte Carlo integrals. Nothing runs on the device.

#[path = "occlusion_truth/camera.rs"]
mod camera;
#[path = "occlusion_truth/closed_forms.rs"]
mod closed_forms;
mod common;
#[path = "occlusion_truth/directions.rs"]
mod directions;
#[path = "occlusion_truth/scenes.rs"]
mod scenes;
