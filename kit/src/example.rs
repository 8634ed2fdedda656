//! What examples share beside the rest: command lines, windows, models and what stands on the screen.

pub mod builder;
pub mod choices;
pub mod dropped_model;
pub mod frame_times;
pub mod gpu_times;
pub mod made_up_sky;
pub mod model;
pub mod numbers;
pub mod opaque_method;
pub mod run;
pub mod text_panel;
