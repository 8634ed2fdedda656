//! What belongs to the device, whichever effect uses it.
//!
//! - `bindings.rs`: names for the bindings of bind groups, and layouts made of them.
//! - `bind_group_cache.rs`: bind groups that are made anew only when what they bind changed.
//! - `needed_limits.rs`: limits of the device that effects need.
//! - `picture_bind_groups.rs`: those of what reads the picture.
//! - `pipeline_watch.rs`: pipelines of this crate that cannot be compiled.
//! - `recovery.rs`: what is left of a device that was lost.
//! - `storage_texture.rs`: what a pass writes and another one reads.
//! - `subgroups.rs`: whether the device has them, and how small they get.
//! - `timed.rs`: passes whose time is recorded.

pub(crate) mod bind_group_cache;
pub(crate) mod bindings;
pub(crate) mod needed_limits;
pub(crate) mod picture_bind_groups;
pub(crate) mod pipeline_watch;
pub(crate) mod recovery;
pub(crate) mod storage_texture;
pub(crate) mod subgroups;
pub(crate) mod timed;
