//! Pictures of lean cameras beside those of Bevy's forward renderer.

mod atmosphere;
mod coming_from_deferred;
mod custom_material;
mod foreign_depth;
mod light_layers;
mod live_changes;
mod packing_loss;
mod parity;
mod resolution_override;
mod shading_extension;
