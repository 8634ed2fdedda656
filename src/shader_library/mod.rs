//! WGSL without bindings that more than one stage imports, registered once, and its twins in Rust.
//!
//! - `layout.{rs,wgsl}`, `layout/`: the words of the G-buffer.
//! - `geometric_normal.{rs,wgsl}`: the normal of the surface itself, from depth.
//! - `tiles.wgsl`: the 8×8 tiles of compute passes; the Rust side is `gpu/tiles.rs`.

pub mod geometric_normal;
pub mod layout;

use bevy::{prelude::*, shader::load_shader_library};

/// Bevy wants all modules that a shader imports, also where `#ifdef` leaves them out.
pub(crate) fn load(app: &mut App) {
    load_shader_library!(app, "tiles.wgsl");
    load_shader_library!(app, "layout.wgsl");
    load_shader_library!(app, "layout/emissive.wgsl");
    load_shader_library!(app, "layout/motion.wgsl");
    load_shader_library!(app, "layout/specialization.wgsl");
    load_shader_library!(app, "geometric_normal.wgsl");
}
