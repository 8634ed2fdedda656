//! Whole apps: plugins in any order, settings that change at run time, warnings, and held resources.

mod actions;
mod bsn;
mod changing_settings;
mod compiling;
mod devices;
mod dropped_model;
mod fallback;
mod few_bindings;
mod first_frame;
mod history;
mod labels;
mod late_switch;
mod levels;
mod lost_device;
mod memory;
mod minimised;
mod no_forward;
mod no_stutter;
mod out_of_memory;
mod panel;
mod plugins;
mod presets;
mod prewarm;
mod shared_targets;
mod statuses;
mod steady_state;
mod switching;
#[cfg(target_os = "linux")]
mod validation_layer;
mod viewer_errors;
mod visible_while_compiling;
mod walk;
