//! Code shared by the examples: command lines, windows, keys, the settings panel, models.

pub mod args;
pub mod builder;
pub mod choices;
pub mod debug_view;
pub mod dropped_model;
pub mod fields;
pub mod gpu_times;
pub mod keys;
pub mod made_up_sky;
pub mod model;
pub mod numbers;
pub mod opaque_method;
pub mod panel;
pub mod renderers;
pub mod run;
pub mod set;
pub mod switch;
pub mod text_panel;
