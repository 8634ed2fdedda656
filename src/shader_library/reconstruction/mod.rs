//! From depth back to the surface that it shows: its position, its normal, and its motion if it is at rest. Each WGSL
//! module stands beside its twin in Rust, which is here for tests and measurements; only the device's is used to render.

pub mod motion;
pub mod normal;
pub mod position;
