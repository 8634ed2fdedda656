//! Checks the ground truth for ambient occlusion: closed forms of scenes against Monte Carlo integrals, and the screen-space integral
//! of depth buffers against closed forms. Nothing runs on the device.

mod camera;
mod directions;
mod integrator;
mod scenes;
