//! The special shading models, one file each: bit table of the arguments, packing and unpacking, lighting. Each WGSL module has a
//! Rust twin for tests, measurements, and materials whose arguments are known on the CPU.
//!
//! [`MODELS`] is the table of all models. The specialization word (`shader_library/layout/specialization.rs`) has 17 bits for the
//! arguments of one model. The largest error of linear values is half a step; the files state those of others.
//! `tests/shaders/layout_optional.rs` measures and bounds them.

pub mod anisotropy;
pub mod clearcoat;
pub mod diffuse_transmission;
pub mod rim;
pub mod subsurface;
mod table;
pub mod unlit;

pub use table::{MODELS, Model, ShadingModel};

use bevy::{prelude::*, shader::load_shader_library};

pub(crate) fn load(app: &mut App) {
    load_shader_library!(app, "anisotropy.wgsl");
    load_shader_library!(app, "diffuse_transmission.wgsl");
    load_shader_library!(app, "clearcoat.wgsl");
    load_shader_library!(app, "rim.wgsl");
    load_shader_library!(app, "subsurface.wgsl");
    load_shader_library!(app, "unlit.wgsl");
}
