//! Rules of Bevy that lighting repeats. `docs/internals/porting.md` has them all.

// - `background.rs`: the lit part of a target, and its clear colour.
// - `binding_numbers.rs`: binding numbers of the view, light probes and decals.
// - `definitions.rs`: shader definitions of Bevy's part of the shader.
// - `light_order.rs`: indices of lights and decals.
// - `view_entries.rs`: Bevy's resources that lighting binds.
// - `soft_shadows.rs`: the sampler of percentage-closer soft shadows.
// - `shadow_maps.wgsl`: visibility in shadow maps.
// - `contact_shadow.wgsl`: contact shadows.

pub(super) mod background;
pub mod binding_numbers;
pub mod definitions;
pub(super) mod light_order;
pub(super) mod soft_shadows;
pub(super) mod view_entries;
