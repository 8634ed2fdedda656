// What the passes bind: each imports what it uses.
#define_import_path bevy_lean_deferred::screen_space::subsurface::bindings

#import bevy_lean_deferred::screen_space::subsurface::view::SubsurfaceView

@group(0) @binding(0) var<uniform> view: SubsurfaceView;
/// Those with special surfaces: how many, and their corners.
@group(0) @binding(1) var<storage, read> tiles: array<u32>;
/// The light that enters surfaces: `lighting/subsurface_light.wgsl`.
@group(0) @binding(2) var light_texture: texture_2d<u32>;
/// What the pixels show whose light scatters.
@group(0) @binding(3) var picture_texture: texture_2d<u32>;
@group(0) @binding(4) var depth_texture: texture_depth_2d;
@group(0) @binding(5) var output_texture: texture_storage_2d<rgba16float, write>;
@group(0) @binding(6) var level_0: texture_storage_2d<rg32uint, write>;
@group(0) @binding(7) var level_1: texture_storage_2d<rg32uint, write>;
@group(0) @binding(8) var level_2: texture_storage_2d<rg32uint, write>;
@group(0) @binding(9) var level_3: texture_storage_2d<rg32uint, write>;
/// Light that has scattered along rows, word by pixel.
@group(0) @binding(10) var across_texture: texture_2d<u32>;
@group(0) @binding(11) var across_output: texture_storage_2d<r32uint, write>;
