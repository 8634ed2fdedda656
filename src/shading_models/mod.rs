//! The special shading models, one WGSL file each: bit table of the arguments, packing and unpacking, lighting. Materials whose
//! arguments are known on the CPU pack them in Rust.
//!
//! [`MODELS`] is the table of all models. The specialization word (`shader_library/layout/specialization.wgsl`) has 17 bits for the
//! arguments of one model. The largest error of linear values is half a step; the files state those of others.
//! `tests/shaders/layout_optional.rs` measures and bounds them.

pub mod rim;
pub mod subsurface;
mod table;

pub use table::{ARGUMENT_BITS, LARGEST_UNLIT, MODELS, Model, ShadingModel};

use bevy::{prelude::*, shader::load_shader_library};

pub(crate) fn load(app: &mut App) {
    load_shader_library!(app, "anisotropy.wgsl");
    load_shader_library!(app, "diffuse_transmission.wgsl");
    load_shader_library!(app, "clearcoat.wgsl");
    load_shader_library!(app, "rim.wgsl");
    load_shader_library!(app, "subsurface.wgsl");
    load_shader_library!(app, "unlit.wgsl");
}
