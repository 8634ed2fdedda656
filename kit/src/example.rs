//! Code shared by the examples: command lines, windows, models and on-screen text.

pub mod builder;
pub mod choices;
pub mod debug_view;
pub mod dropped_model;
pub mod frame_times;
pub mod gpu_times;
pub mod made_up_sky;
pub mod model;
pub mod numbers;
pub mod opaque_method;
pub mod run;
pub mod text_panel;
