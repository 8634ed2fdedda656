//! Shared by the tests, benches and examples of `bevy_lean_deferred`: headless rendering, picture comparison, scenes built in code, the
//! shipped shaders on a separate device, and ground truth.
#![allow(
    clippy::new_without_default,
    reason = "what opens a device is no default"
)]

pub mod analytic_balls;
pub mod analytic_lamps;
pub mod analytic_light;
pub mod analytic_mirrors;
pub mod analytic_slabs;
pub mod bench_args;
pub mod bench_spans;
pub mod compute;
pub mod device;
pub mod example;
pub mod exposure_gpu;
pub mod exposure_reference;
pub mod figures;
pub mod foreign_material;
pub mod gpu;
pub mod gpu_time;
pub mod gpu_usage;
pub mod hdr;
pub mod headless;
pub mod lean;
pub mod levels;
pub mod log_watch;
pub mod metrics;
pub mod motion;
pub mod occlusion;
pub mod occlusion_gpu;
pub mod own_process;
pub mod random;
pub mod random_values;
pub mod reference;
pub mod renderer;
pub mod scenes;
pub mod shader_files;
pub mod size;
pub mod skipped;
pub mod stalled_pipelines;
pub mod walk;
pub mod wgsl;
