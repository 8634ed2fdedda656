//! What is drawn into the G-buffer, when, and with which targets.

mod motion_vectors;
mod occlusion_culling;
mod optional_targets;
mod sorting;
