//! Pictures of lean cameras against those of Bevy's forward renderer.
//!
//! Each test has a process of its own: together they would exceed the memory of many machines, see `lab/kit/src/own_process.rs`.

mod accuracy;
mod atmosphere;
mod bright_light;
mod coming_from_deferred;
mod custom_material;
mod debug_views;
mod decals;
mod far_plane;
mod foreign_depth;
mod forward_light;
mod fragment_shaders;
mod light_culling;
mod light_layers;
mod light_parts;
mod live_changes;
mod ocean;
mod oracle;
mod overlays;
mod own_passes;
mod packing_loss;
mod parity;
mod resolution_override;
mod rounding;
mod screen_space_light;
mod shading_extension;
mod shadow_bias;
mod soft_shadows;
mod supersets;
