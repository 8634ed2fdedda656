//! The ground truth for ambient occlusion holds: closed forms beside Monte Carlo integrals, and the screen-space
//! integral of depth buffers beside closed forms. Nothing runs on the device.

#[path = "occlusion_truth/camera.rs"]
mod camera;
#[path = "occlusion_truth/closed_forms.rs"]
mod closed_forms;
mod common;
#[path = "occlusion_truth/directions.rs"]
mod directions;
#[path = "occlusion_truth/integrator.rs"]
mod integrator;
#[path = "occlusion_truth/scenes.rs"]
mod scenes;
