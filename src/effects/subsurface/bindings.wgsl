// Bindings of the subsurface scattering passes. Each pass imports those that it uses.
#define_import_path bevy_lean_deferred::effects::subsurface::bindings

#import bevy_lean_deferred::effects::subsurface::view::SubsurfaceUniform

@group(0) @binding(0) var<uniform> view: SubsurfaceUniform;
/// Tiles whose light scatters, in the layout of `lighting/subsurface_light.wgsl`.
@group(0) @binding(1) var<storage, read> tiles: array<u32>;
/// Light that enters surfaces: of the next finer level or, to be scattered, of this one.
@group(0) @binding(2) var light_texture: texture_2d<u32>;
/// Light that enters surfaces, of the next coarser level, where `scattered_texture` is of the one after it.
@group(0) @binding(3) var coarser_texture: texture_2d<u32>;
@group(0) @binding(4) var level_output: texture_storage_2d<rg32uint, write>;
/// Outputs of the levels that follow.
@group(0) @binding(5) var next_output: texture_storage_2d<rg32uint, write>;
@group(0) @binding(6) var last_output: texture_storage_2d<rg32uint, write>;
/// Scattered light of the next coarser level, or of the one after it.
@group(0) @binding(7) var scattered_texture: texture_2d<u32>;
@group(0) @binding(8) var scattered_output: texture_storage_2d<rg32uint, write>;
@group(0) @binding(9) var normal_texture: texture_2d<u32>;
/// Light that enters surfaces, of the picture. Where it has none, normals are not of this frame.
@group(0) @binding(10) var entering_texture: texture_2d<u32>;
/// `Receiver` words of the pixels whose light scatters.
@group(0) @binding(11) var picture_texture: texture_2d<u32>;
@group(0) @binding(12) var output_texture: texture_storage_2d<rgba16float, write>;
