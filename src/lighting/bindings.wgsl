// Bindings of the lighting pass beside Bevy's view and light probes.
#define_import_path bevy_lean_deferred::lighting::bindings

struct LightingUniform {
    /// Clear colour of the camera, as the main texture stores it.
    background: vec4<f32>,
    /// In pixels of the render target.
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// `edge.x * depth + edge.y` is the depth step that separates surfaces one pixel apart.
    edge: vec2<f32>,
    /// 1 if pixels without geometry are set to `background`.
    writes_background: u32,
    /// 1 if the G-buffer is undefined where depth is 0.
    depth_tells_geometry: u32,
    /// Parameters of the filter of ambient occlusion: as in `occlusion_filter.wgsl`.
    occlusion_edge: vec3<f32>,
    occlusion_intensity: f32,
    /// Share of the occlusion that also darkens direct light, 0 to 1.
    occlusion_of_direct_light: f32,
    /// Share that darkens the light of lightmaps, 0 to 1.
    occlusion_of_baked_light: f32,
    /// Columns of the viewport, from the left, that show a debug view.
    debug_columns: u32,
    /// Parts that the view needs: bits of `parts.wgsl`.
    parts: u32,
    /// 1 if a texel of `indirect_diffuse_texture` represents 2×2 pixels.
    diffuse_is_half: u32,
}

#ifdef LIGHT_LAYERS
/// Visibility masks of lights, light probes and decals, by the index that Bevy's shaders use.
struct LightLayersTable {
    directional_lights: array<u32, 10>,
    rect_lights: array<u32, 8>,
    reflection_probes: array<u32, 8>,
    irradiance_volumes: array<u32, 8>,
    clustered_count: u32,
    /// x: mask of the point or spot light with this index; y: of the decal. All from `clustered_count` on affect everything.
    clustered: array<vec2<u32>>,
}
#endif

@group(2) @binding(0) var surface_texture: texture_2d<u32>;
@group(2) @binding(1) var normal_texture: texture_2d<u32>;
@group(2) @binding(2) var output_texture: texture_storage_2d<rgba16float, write>;
@group(2) @binding(3) var<uniform> uniforms: LightingUniform;
#ifdef LEAN_AMBIENT_OCCLUSION
@group(2) @binding(4) var nearest_sampler: sampler;
@group(2) @binding(5) var occlusion_texture: texture_2d<f32>;
#endif
#ifdef GBUFFER_VALID_MASK
@group(2) @binding(12) var valid_mask_texture: texture_2d<u32>;
#endif
#ifdef DIFFUSE_LIGHT
@group(2) @binding(13) var diffuse_light_texture: texture_storage_2d<r32uint, write>;
#endif
#ifdef SCATTERS_LIGHT
@group(2) @binding(16) var subsurface_light_texture: texture_storage_2d<rg32uint, write>;
@group(2) @binding(17) var subsurface_picture_texture: texture_storage_2d<rgba32uint, write>;
@group(2) @binding(18) var<storage, read_write> scattering_tiles: array<atomic<u32>>;
#endif
#ifdef INDIRECT_SPECULAR
@group(2) @binding(14) var indirect_specular_texture: texture_2d<f32>;
#endif
#ifdef INDIRECT_DIFFUSE
@group(2) @binding(15) var indirect_diffuse_texture: texture_2d<f32>;
#endif
#ifdef GBUFFER_EMISSIVE
@group(2) @binding(7) var emissive_texture: texture_2d<u32>;
#endif
#ifdef GBUFFER_SPECIALIZATION
@group(2) @binding(8) var specialization_texture: texture_2d<u32>;
#endif
#ifdef GBUFFER_MOTION
@group(2) @binding(9) var motion_texture: texture_2d<u32>;
#endif
#ifdef GBUFFER_VISIBILITY_MASK
@group(2) @binding(10) var visibility_mask_texture: texture_2d<u32>;
#endif
#ifdef LIGHT_LAYERS
@group(2) @binding(11) var<storage> light_layers: LightLayersTable;
#endif
