//! The shipped WGSL: its storage and results against its Rust twins, and that all of it composes.

mod distance_fog;
mod geometric_normal;
mod history;
mod layout;
mod layout_optional;
mod permutations;
mod properties;
mod reconstruction;
mod reflections;
mod reprojection;
mod screen_space;
mod subsurface;
mod tile_list;
mod twins;
