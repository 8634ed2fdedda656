// Bindings of the diffuse GI passes. Each pass imports those that it uses.
#define_import_path bevy_lean_deferred::effects::diffuse_gi::bindings

#import bevy_lean_deferred::effects::diffuse_gi::view::GiUniform

@group(0) @binding(0) var<uniform> view: GiUniform;
@group(0) @binding(1) var depth_texture: texture_depth_2d;
@group(0) @binding(2) var normal_texture: texture_2d<u32>;
/// Diffuse light of the last frame, one word per pixel of its viewport.
@group(0) @binding(3) var diffuse_light_texture: texture_2d<u32>;
/// Motion of each pixel since the last frame; valid with `view.has_motion`.
@group(0) @binding(4) var motion_texture: texture_2d<f32>;
/// x: exposure with which the last frame was shown, in stops.
@group(0) @binding(5) var<uniform> shown_exposure: vec4<f32>;
/// Levels of the last frame.
@group(0) @binding(6) var last_levels: texture_2d<u32>;
/// Levels of this frame, packed by `pack_entry`.
@group(0) @binding(7) var levels: texture_2d<u32>;
@group(0) @binding(8) var level_0: texture_storage_2d<rg32uint, write>;
@group(0) @binding(9) var level_1: texture_storage_2d<rg32uint, write>;
@group(0) @binding(10) var level_2: texture_storage_2d<rg32uint, write>;
@group(0) @binding(11) var level_3: texture_storage_2d<rg32uint, write>;
/// Mean radiance from surfaces, and the share of the hemisphere that they cover, before filtering.
@group(0) @binding(12) var gathered_texture: texture_2d<f32>;
@group(0) @binding(13) var gathered_output: texture_storage_2d<rgba16float, write>;
@group(0) @binding(14) var output_texture: texture_storage_2d<rgba16float, write>;
/// Picture after the opaque passes, and the diffuse light of this frame, to which part of it is added.
@group(0) @binding(15) var picture_texture: texture_2d<f32>;
@group(0) @binding(16) var diffuse_light_output: texture_storage_2d<r32uint, write>;

/// Depth step that separates surfaces `pixels` apart.
fn edge_step(depth: f32, pixels: f32) -> f32 {
    return (view.edge.x * depth + view.edge.y) * pixels;
}
