// What the passes bind: each imports what it uses.
#define_import_path bevy_lean_deferred::screen_space::diffuse_gi::bindings

#import bevy_lean_deferred::gbuffer::layout::light::{pack_light, unpack_light}
#import bevy_lean_deferred::screen_space::diffuse_gi::view::GiView

@group(0) @binding(0) var<uniform> view: GiView;
@group(0) @binding(1) var depth_texture: texture_depth_2d;
@group(0) @binding(2) var normal_texture: texture_2d<u32>;
/// What lighting wrote in the last frame, word by pixel of the viewport.
@group(0) @binding(3) var diffuse_light_texture: texture_2d<u32>;
/// From where the motion of each pixel began, with `view.has_motion`.
@group(0) @binding(4) var motion_texture: texture_2d<f32>;
/// The last frame's levels.
@group(0) @binding(5) var last_levels: texture_2d<u32>;
/// This frame's: depth, as its bits, and the word of the last frame's light.
@group(0) @binding(6) var levels: texture_2d<u32>;
@group(0) @binding(7) var level_0: texture_storage_2d<rg32uint, write>;
@group(0) @binding(8) var level_1: texture_storage_2d<rg32uint, write>;
@group(0) @binding(9) var level_2: texture_storage_2d<rg32uint, write>;
@group(0) @binding(10) var level_3: texture_storage_2d<rg32uint, write>;
/// Mean radiance from surfaces, and what part of the hemisphere they take; not yet filtered.
@group(0) @binding(11) var gathered_texture: texture_2d<f32>;
@group(0) @binding(12) var output_texture: texture_storage_2d<rgba16float, write>;
/// What the opaque meshes have left, and where some of it joins this frame's diffuse light.
@group(0) @binding(13) var picture_texture: texture_2d<f32>;
@group(0) @binding(14) var diffuse_light_output: texture_storage_2d<r32uint, write>;
/// x: in stops, as the last frame was shown.
@group(0) @binding(15) var<uniform> shown_exposure: vec4<f32>;

/// What a texel of a level shows.
struct Entry {
    /// 0 where no surface is.
    depth: f32,
    /// That it sent out in the last frame, exposed as this one is.
    light: vec3<f32>,
}

fn pack_entry(entry: Entry) -> vec4<u32> {
    return vec4(bitcast<u32>(entry.depth), pack_light(entry.light), 0u, 0u);
}

fn unpack_entry(words: vec2<u32>) -> Entry {
    return Entry(bitcast<f32>(words.x), unpack_light(words.y));
}

/// The step in depth that separates surfaces so many pixels apart.
fn edge_step(depth: f32, pixels: f32) -> f32 {
    return (view.edge.x * depth + view.edge.y) * pixels;
}
