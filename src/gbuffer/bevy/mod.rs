//! Rules of Bevy that the G-buffer repeats, and changes to Bevy's phases and passes. `docs/internals/porting.md` has them all.

// - `batching.rs`: batching of the phases.
// - `depth_copy.rs`: the copy of depth for its readers.
// - `extracted.rs`: meshes that Bevy extracted in this frame.
// - `forward_draws.rs`: changes the pipelines with which Bevy's passes draw meshes.
// - `forward_pipelines.rs`: specializes the pipelines of meshes that Bevy's passes draw.
// - `invariant_positions.rs`: makes all vertex shaders of Bevy compute the same positions.
// - `lightmaps.rs`: Bevy's list of lightmapped meshes.
// - `phases.rs`: removes meshes from Bevy's phases, and returns them.
// - `pipeline_filter.rs`: limits the meshes that Bevy's queue systems see.
// - `queue_rules.rs`: for which cameras and in which order Bevy queues meshes, and for which it waits.
// - `texture_defs.rs`: textures of `StandardMaterial` that depend on Bevy's features.

pub(super) mod batching;
pub(super) mod depth_copy;
pub(super) mod extracted;
pub(super) mod forward_draws;
pub(super) mod forward_pipelines;
pub(super) mod invariant_positions;
pub(super) mod lightmaps;
pub(super) mod phases;
pub(super) mod pipeline_filter;
pub(super) mod queue_rules;
pub(super) mod texture_defs;
