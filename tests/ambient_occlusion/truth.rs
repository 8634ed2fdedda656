//! The ground truth for ambient occlusion holds: closed forms beside Monte Carlo integrals, and the screen-space
//! integral of depth buffers beside closed forms. Nothing runs on the device.

mod camera;
mod closed_forms;
mod directions;
mod integrator;
mod scenes;
