//! What tests and benches share: rendering without a window, comparing pictures, scenes built in code, ground truth for
//! ambient occlusion.
#![allow(dead_code, reason = "each binary uses a part")]

pub mod compute;
pub mod exposure_gpu;
pub mod gpu;
pub mod headless;
pub mod held_back;
pub mod lean;
pub mod metrics;
pub mod occlusion;
pub mod occlusion_gpu;
pub mod random;
pub mod scenes;
pub mod size;
