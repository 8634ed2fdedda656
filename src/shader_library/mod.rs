//! WGSL without bindings that more than one stage imports, registered once, and its twins in Rust.
//!
//! - `layout.{rs,wgsl}`, `layout/`: the words of the G-buffer.
//! - `reconstruction/`: from depth back to positions, normals and motion.
//! - `horizon.{rs,wgsl}`: what a pair of horizons hides. `ggx.{rs,wgsl}`: the lobe of a rough mirror.
//! - `pattern.wgsl`: which texels of a picture look where. `tiles.{rs,wgsl}`: the 8×8 tiles of compute passes, and their order.
//!   `workgroup.wgsl`: what the invocations of a workgroup tell one another.

pub mod ggx;
pub mod horizon;
pub mod layout;
pub mod reconstruction;
pub mod tiles;

use bevy::{prelude::*, shader::load_shader_library};

/// Bevy wants all modules that a shader imports, also where `#ifdef` leaves them out.
pub(crate) fn load(app: &mut App) {
    load_shader_library!(app, "tiles.wgsl");
    load_shader_library!(app, "workgroup.wgsl");
    load_shader_library!(app, "pattern.wgsl");
    load_shader_library!(app, "rounding.wgsl");
    load_shader_library!(app, "ggx.wgsl");
    load_shader_library!(app, "horizon.wgsl");
    load_shader_library!(app, "layout.wgsl");
    load_shader_library!(app, "layout/light.wgsl");
    load_shader_library!(app, "layout/motion.wgsl");
    load_shader_library!(app, "layout/specialization.wgsl");
    load_shader_library!(app, "reconstruction/position.wgsl");
    load_shader_library!(app, "reconstruction/normal.wgsl");
    load_shader_library!(app, "reconstruction/motion.wgsl");
    load_shader_library!(app, "reconstruction/normal_from_depth.wgsl");
}
