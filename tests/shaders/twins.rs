//! Data that Rust and WGSL share: the layouts of structs, the numbers of bindings, and constants.
//!
//! `shipped.rs` reads all WGSL below `src`, so that no declaration of a shader is left out: each binding, each struct in a binding, and
//! each constant with a Rust constant of the same name beside it or beside its twins in `lab/kit/src/reference`. The values compared are
//! those that naga computes.

mod bindings;
mod constants;
mod limits;
mod shaders;
mod shipped;
mod structs;
