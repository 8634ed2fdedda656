//! What Rust and WGSL both know: the layouts of structs, the numbers of bindings, and constants.
//!
//! `shipped.rs` reads all WGSL below `src`, so that nothing which a shader declares is left out: each binding, each struct that one
//! has, and each constant of which the Rust beside it has one of the same name. What is compared is what naga makes of it.

mod bindings;
mod constants;
mod limits;
mod shaders;
mod shipped;
mod structs;
