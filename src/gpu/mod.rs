//! Helpers for the device, shared by the effects.
//!
//! - `bindings.rs`: named binding numbers, and bind group layouts from them.
//! - `bind_group_cache.rs`: bind groups that are recreated only when a bound resource has changed.
//! - `effect_pipelines.rs`: the passes of an effect, and their pipelines by key.
//! - `growing_size.rs`: sizes of textures of views that are resized while they are drawn.
//! - `layout_limits.rs`: counts bindings against the limits of the device.
//! - `named.rs`: structs of system parameters and queries.
//! - `needed_limits.rs`: device limits that effects need.
//! - `picture_bind_groups.rs`: bind groups of passes that read the main texture.
//! - `pipeline_budget.rs`: limits the pipelines that are requested per frame.
//! - `pipeline_watch.rs`: reports pipelines of this crate that fail to compile.
//! - `recovery.rs`: removes from views the resources of a lost device.
//! - `shader_defs.rs`: shader definitions by tables of conditions.
//! - `storage_texture.rs`: textures that one pass writes and another reads.
//! - `subgroups.rs`: subgroup support, and the smallest subgroup size.
//! - `texture_bytes.rs`: sizes of textures in memory.
//! - `timed.rs`: passes whose GPU time is recorded.
//! - `wgsl_dump.rs`: writes the WGSL of pipelines that fail to compile.

pub(crate) mod bind_group_cache;
pub(crate) mod bindings;
pub(crate) mod effect_pipelines;
pub(crate) mod growing_size;
pub(crate) mod layout_limits;
pub(crate) mod named;
pub(crate) mod needed_limits;
pub(crate) mod picture_bind_groups;
pub(crate) mod pipeline_budget;
pub(crate) mod pipeline_watch;
pub(crate) mod recovery;
pub(crate) mod shader_defs;
pub(crate) mod storage_texture;
pub(crate) mod subgroups;
pub(crate) mod texture_bytes;
pub(crate) mod timed;
mod wgsl_dump;
