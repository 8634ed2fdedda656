//! Binding-free WGSL modules that several stages import, registered once, with the Rust that the crate shares with them.
//!
//! - `layout.{rs,wgsl}`: the words of the G-buffer's base targets, and the formats of all targets.
//! - `layout/`: the words of its optional targets, and packed light.
//! - `reconstruction/`: positions, normals and motion from depth.
//! - `horizon.wgsl`: cosine-weighted occlusion by a pair of horizons.
//! - `occlusion_filter.wgsl`: the filter of ambient occlusion.
//! - `distance_fog.{rs,wgsl}`: Bevy's distance fog, and how to remove it.
//! - `cell.wgsl`: the nearest and the furthest depth of cells of pixels, packed into a word.
//! - `screen_ray.wgsl`: a ray on screen, and its walk from cell to cell.
//! - `gathered.wgsl`: the nearest of four gathered texels, and what lies between them.
//! - `ggx.wgsl`: samples of the GGX lobe.
//! - `pattern.wgsl`: the 4×4 pattern in which neighbouring texels take different directions.
//! - `tiles.{rs,wgsl}`: the 8×8 tiles of compute passes, the order of the pixels in them, and the pixels of half-resolution texels.
//! - `workgroup.wgsl`: a vote over the invocations of a workgroup.
//! - `rounding.wgsl`: rounding without conversions.

pub mod distance_fog;
pub mod layout;
pub mod reconstruction;
pub mod tiles;

use bevy::{prelude::*, shader::load_shader_library};

/// Bevy needs all modules that a shader imports, even where `#ifdef` excludes the import.
pub(crate) fn load(app: &mut App) {
    load_shader_library!(app, "tiles.wgsl");
    load_shader_library!(app, "workgroup.wgsl");
    load_shader_library!(app, "pattern.wgsl");
    load_shader_library!(app, "rounding.wgsl");
    load_shader_library!(app, "distance_fog.wgsl");
    load_shader_library!(app, "cell.wgsl");
    load_shader_library!(app, "screen_ray.wgsl");
    load_shader_library!(app, "gathered.wgsl");
    load_shader_library!(app, "ggx.wgsl");
    load_shader_library!(app, "horizon.wgsl");
    load_shader_library!(app, "occlusion_filter.wgsl");
    load_shader_library!(app, "layout.wgsl");
    load_shader_library!(app, "layout/light.wgsl");
    load_shader_library!(app, "layout/motion.wgsl");
    load_shader_library!(app, "layout/specialization.wgsl");
    load_shader_library!(app, "reconstruction/position.wgsl");
    load_shader_library!(app, "reconstruction/normal.wgsl");
    load_shader_library!(app, "reconstruction/motion.wgsl");
    load_shader_library!(app, "reconstruction/normal_from_depth.wgsl");
}
