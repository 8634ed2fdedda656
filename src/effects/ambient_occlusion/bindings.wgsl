// Bindings of the ambient occlusion passes. Each pass imports those that it uses.
#define_import_path bevy_lean_deferred::effects::ambient_occlusion::bindings

#import bevy_lean_deferred::effects::ambient_occlusion::view::OcclusionUniform
#import bevy_lean_deferred::reconstruction::position as reconstruction

@group(0) @binding(0) var<uniform> view: OcclusionUniform;
@group(0) @binding(1) var depth_texture: texture_depth_2d;
@group(0) @binding(2) var nearest_sampler: sampler;
#ifdef SHADING_NORMALS
@group(0) @binding(3) var normal_texture: texture_2d<u32>;
#endif
@group(0) @binding(4) var output_texture: texture_storage_2d<r8unorm, write>;
@group(0) @binding(5) var occlusion_texture: texture_2d<f32>;
@group(0) @binding(6) var sparse_depth_texture: texture_2d<f32>;
@group(0) @binding(7) var sparse_depth_output: texture_storage_2d<r32float, write>;

fn is_in_view(pixel: vec2<i32>) -> bool {
    // Negative coordinates wrap to values above any size.
    return all(bitcast<vec2<u32>>(pixel) < view.viewport_size);
}

fn depth_at(pixel: vec2<i32>) -> f32 {
    return textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + pixel, 0);
}

/// View-space position of the centre of `pixel`.
fn view_position(pixel: vec2<i32>, depth: f32) -> vec3<f32> {
    return reconstruction::view_position(view.view_from_pixel, vec3(vec2<f32>(pixel) + 0.5, depth));
}

/// Unit vector from `position` to the viewer.
fn direction_to_viewer(position: vec3<f32>) -> vec3<f32> {
#ifdef PROJECTION_ORTHOGRAPHIC
    return vec3(0.0, 0.0, 1.0);
#else
    return normalize(-position);
#endif
}

/// Projected radius at a surface.
struct Radius {
    /// Per axis; negative where the projection mirrors.
    pixels: vec2<f32>,
    /// Factor by which clamping `pixels` shortened the radius: 1 or more.
    excess: f32,
}

/// Projects the radius at the surface at this `position` and `depth`, and clamps it.
fn radius_at(position: vec3<f32>, depth: f32) -> Radius {
#ifdef PROJECTION_PERSPECTIVE
    let nearness = view.edge.x * depth + view.edge.y;
#else ifdef PROJECTION_ORTHOGRAPHIC
    let nearness = 1.0;
#else
    let nearness = 1.0 / max(-position.z, 1e-6);
#endif
    let pixels = view.radius_in_pixels * min(nearness, view.largest_nearness);
    return Radius(pixels, max(nearness / view.largest_nearness, 1.0));
}

fn largest_side(pixels: vec2<f32>) -> f32 {
    return max(abs(pixels.x), abs(pixels.y));
}
