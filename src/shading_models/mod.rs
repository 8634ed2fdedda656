//! The shading models beside the plain one, a file each: the bits of its arguments, how they are packed and unpacked, and
//! how it is lit. Each WGSL module stands beside its twin in Rust, which is here for tests and measurements, and for
//! materials whose arguments are known on the CPU.
//!
//! The specialization word (`shader_library/layout/specialization.rs`) has 17 bits for the arguments of one model.
//! Largest errors of linear values: half a step; of others, in the files. `tests/shaders/layout_optional.rs` measures and
//! bounds them.

pub mod anisotropy;
pub mod backlight;
pub mod clearcoat;
pub mod rim;
pub mod subsurface;
pub mod unlit;

use bevy::{prelude::*, shader::load_shader_library};

pub(crate) fn load(app: &mut App) {
    load_shader_library!(app, "anisotropy.wgsl");
    load_shader_library!(app, "backlight.wgsl");
    load_shader_library!(app, "clearcoat.wgsl");
    load_shader_library!(app, "rim.wgsl");
    load_shader_library!(app, "subsurface.wgsl");
    load_shader_library!(app, "unlit.wgsl");
}
