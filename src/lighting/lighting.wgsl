// Lights every pixel of the packed G-buffer, with Bevy's own lighting functions.
#import bevy_lean_deferred::gbuffer::layout
#import bevy_lean_deferred::lighting::geometric_normal::{
    nearer_side, normal_from_positions, straighter_side,
}
#import bevy_lean_deferred::tiles::pixel_in_view
#import bevy_pbr::{
    mesh_types::MESH_FLAGS_SHADOW_RECEIVER_BIT,
    mesh_view_bindings::{depth_prepass_texture as depth_texture, view},
    pbr_functions::{apply_pbr_lighting, calculate_view, main_pass_post_lighting_processing},
    pbr_types::{PbrInput, STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT, pbr_input_new},
}

#ifdef CLUSTERED_DECALS_ARE_USABLE
#import bevy_pbr::decal::clustered::apply_decals
#endif

#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
#import bevy_pbr::mesh_view_bindings::screen_space_ambient_occlusion_texture
#endif

#ifdef APPLIES_VISIBILITY
#import bevy_pbr::{lighting::perceptualRoughnessToRoughness, ssao_utils::ssao_multibounce}
#endif

#ifdef LEAN_AMBIENT_OCCLUSION
#import bevy_lean_deferred::ambient_occlusion::{filter::filtered_occlusion, view::OcclusionView}
#endif

struct LightingUniform {
    /// The camera's clear colour, as the main texture stores it.
    background: vec4<f32>,
    /// Pixels of the render target.
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// 1 if pixels without geometry are to be set to `background`.
    writes_background: u32,
    row_stride: u32,
}

@group(2) @binding(0) var surface_texture: texture_2d<u32>;
@group(2) @binding(1) var normal_texture: texture_2d<u32>;
@group(2) @binding(2) var output_texture: texture_storage_2d<rgba16float, write>;
@group(2) @binding(3) var<uniform> uniforms: LightingUniform;
#ifdef LEAN_AMBIENT_OCCLUSION
@group(2) @binding(4) var<uniform> occlusion_view: OcclusionView;
@group(2) @binding(5) var nearest_sampler: sampler;
@group(2) @binding(6) var occlusion_texture: texture_2d<f32>;
#endif

/// Keeps positions finite for geometry so far away that its reversed depth is 0, and the squares of their differences
/// within f32.
const SMALLEST_DEPTH: f32 = 1e-14;

fn view_position(pixel: vec2<i32>, depth: f32) -> vec3<f32> {
    let uv = (vec2<f32>(pixel) + 0.5 - view.main_pass_viewport.xy) / view.main_pass_viewport.zw;
    let ndc = uv * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    // Through view space, not by `world_from_clip`: that matrix loses digits far from the origin.
    let position = view.view_from_clip * vec4(ndc, max(depth, SMALLEST_DEPTH), 1.0);
    return position.xyz / position.w;
}

#ifdef GEOMETRIC_NORMAL
/// Further from any surface than the other side of an axis can be, so that that is chosen.
const OUTSIDE: f32 = 1e9;

fn is_in_viewport(pixel: vec2<i32>) -> bool {
    let p = pixel - vec2<i32>(uniforms.viewport_origin);
    return all(p >= vec2(0)) && all(p < vec2<i32>(uniforms.viewport_size));
}

/// Depth at `pixel`, `OUTSIDE` beyond the viewport.
fn depth_at(pixel: vec2<i32>) -> f32 {
    if !is_in_viewport(pixel) {
        return OUTSIDE;
    }
    return textureLoad(depth_texture, pixel, 0);
}

/// View-space normal of the surface at `pixel`, unit length, facing the viewer.
fn geometric_normal(pixel: vec2<i32>, depth: f32, position: vec3<f32>) -> vec3<f32> {
    let n = normal_from_taps(pixel, depth, position);
    // A mirrored projection turns the order of the taps, and the normal, around.
    let to_viewer = select(-position, vec3(0.0, 0.0, 1.0), view.clip_from_view[3].w == 1.0);
    return select(n, -n, dot(n, to_viewer) < 0.0);
}

fn normal_from_taps(pixel: vec2<i32>, depth: f32, position: vec3<f32>) -> vec3<f32> {
    let x = vec2(1, 0);
    let y = vec2(0, 1);
#ifdef GEOMETRIC_NORMAL_THREE_TAP
    // Right and below, but inwards in the last column and row.
    let h = select(-1, 1, is_in_viewport(pixel + x));
    let v = select(-1, 1, is_in_viewport(pixel + y));
    return normal_from_positions(
        position,
        view_position(pixel + h * x, depth_at(pixel + h * x)), f32(h),
        view_position(pixel + v * y, depth_at(pixel + v * y)), f32(v),
    );
#else
    let left = depth_at(pixel - x);
    let right = depth_at(pixel + x);
    let top = depth_at(pixel - y);
    let bottom = depth_at(pixel + y);
#ifdef GEOMETRIC_NORMAL_FIVE_TAP
    let h = nearer_side(depth, left, right);
    let v = nearer_side(depth, top, bottom);
#else
    let h = straighter_side(depth, left, depth_at(pixel - 2 * x), right, depth_at(pixel + 2 * x));
    let v = straighter_side(depth, top, depth_at(pixel - 2 * y), bottom, depth_at(pixel + 2 * y));
#endif
    return normal_from_positions(
        position,
        view_position(pixel + i32(h) * x, select(left, right, h > 0.0)), h,
        view_position(pixel + i32(v) * y, select(top, bottom, v > 0.0)), v,
    );
#endif
}
#endif  // GEOMETRIC_NORMAL

fn pbr_input_from_gbuffer(pixel: vec2<i32>, normal_word: u32, depth: f32) -> PbrInput {
    let surface_word = textureLoad(surface_texture, pixel, 0).r;
    let position = view_position(pixel, depth);

    var pbr = pbr_input_new();
    pbr.material.base_color = vec4(layout::unpack_albedo(surface_word), 1.0);
    pbr.material.metallic = layout::unpack_metallic(surface_word);
    pbr.material.perceptual_roughness = layout::unpack_roughness(normal_word);
    pbr.material.flags = STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT;
    pbr.diffuse_occlusion = vec3(layout::unpack_occlusion(surface_word));
    pbr.frag_coord = vec4(vec2<f32>(pixel) + 0.5, depth, 1.0);
    pbr.world_position = vec4((view.world_from_view * vec4(position, 1.0)).xyz, 1.0);
    pbr.is_orthographic = view.clip_from_view[3].w == 1.0;
    pbr.V = calculate_view(pbr.world_position, pbr.is_orthographic);
    pbr.N = layout::unpack_normal(normal_word);
#ifdef GEOMETRIC_NORMAL
    let geometric = geometric_normal(pixel, depth, position);
    pbr.world_normal = (view.world_from_view * vec4(geometric, 0.0)).xyz;
#else
    pbr.world_normal = pbr.N;
#endif
#ifdef SHADOW_MAPS
    pbr.flags = MESH_FLAGS_SHADOW_RECEIVER_BIT;
#endif
    return pbr;
}

#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
fn apply_ssao(pbr: ptr<function, PbrInput>, pixel: vec2<i32>) {
    let ssao = textureLoad(screen_space_ambient_occlusion_texture, pixel, 0).r;
    apply_visibility(pbr, ssao, ssao_multibounce(ssao, (*pbr).material.base_color.rgb));
}
#endif

#ifdef LEAN_AMBIENT_OCCLUSION
/// Returns the visibility.
fn apply_occlusion(pbr: ptr<function, PbrInput>, pixel: vec2<i32>, depth: f32) -> f32 {
    let occlusion = filtered_occlusion(
        occlusion_texture,
        nearest_sampler,
        depth_texture,
        occlusion_view,
        pixel - vec2<i32>(uniforms.viewport_origin),
        depth,
    );
    let visibility = 1.0 - occlusion;
#ifdef OCCLUSION_MULTIBOUNCE
    apply_visibility(pbr, visibility, ssao_multibounce(visibility, (*pbr).material.base_color.rgb));
#else
    apply_visibility(pbr, visibility, vec3(visibility));
#endif
    return visibility;
}
#endif

#ifdef APPLIES_VISIBILITY
/// As Bevy's `pbr_fragment` applies its own occlusion.
fn apply_visibility(pbr: ptr<function, PbrInput>, visibility: f32, tinted: vec3<f32>) {
    (*pbr).diffuse_occlusion = min((*pbr).diffuse_occlusion, tinted);
    // Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering".
    let n_dot_v = max(dot((*pbr).N, (*pbr).V), 0.0001);
    let roughness = perceptualRoughnessToRoughness((*pbr).material.perceptual_roughness);
    let specular = saturate(pow(n_dot_v + visibility, exp2(-16.0 * roughness - 1.0)) - 1.0 + visibility);
    (*pbr).specular_occlusion = min((*pbr).specular_occlusion, specular);
}
#endif  // APPLIES_VISIBILITY

#ifdef DEBUG_VIEW
fn debug_color(pbr: PbrInput) -> vec3<f32> {
#ifdef DEBUG_ALBEDO
    return pbr.material.base_color.rgb;
#else ifdef DEBUG_METALLIC
    return vec3(pbr.material.metallic);
#else ifdef DEBUG_OCCLUSION
    return pbr.diffuse_occlusion;
#else ifdef DEBUG_NORMAL
    return pbr.N * 0.5 + 0.5;
#else ifdef DEBUG_ROUGHNESS
    return vec3(pbr.material.perceptual_roughness);
#else ifdef DEBUG_GEOMETRIC_NORMAL
    return pbr.world_normal * 0.5 + 0.5;
#else
    let z = (view.view_from_world * pbr.world_position).z;
    return vec3(1.0 / (1.0 + abs(z)));
#endif
}
#endif

fn light(pixel: vec2<i32>, normal_word: u32, depth: f32) -> vec4<f32> {
    var pbr = pbr_input_from_gbuffer(pixel, normal_word, depth);
#ifdef DEBUG_VIEW
    return vec4(debug_color(pbr), 1.0);
#else
#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
    apply_ssao(&pbr, pixel);
#endif
#ifdef CLUSTERED_DECALS_ARE_USABLE
    apply_decals(&pbr);
#endif
#ifdef LEAN_AMBIENT_OCCLUSION
    let visibility = apply_occlusion(&pbr, pixel, depth);
#endif
#ifdef OCCLUSION_DEBUG_VIEW
    return vec4(vec3(visibility), 1.0);
#else
    var color = apply_pbr_lighting(pbr);
#ifdef OCCLUSION_OF_DIRECT_LIGHT
    // With all indirect light occluded only direct light is left.
    pbr.diffuse_occlusion = vec3(0.0);
    pbr.specular_occlusion = 0.0;
    let hidden = occlusion_view.direct_light_affect * (1.0 - visibility);
    color = vec4(color.rgb - hidden * apply_pbr_lighting(pbr).rgb, color.a);
#endif
    return main_pass_post_lighting_processing(pbr, color);
#endif  // OCCLUSION_DEBUG_VIEW
#endif
}

@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(num_workgroups) tiles: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let place = pixel_in_view(tile.xy, tiles.xy, uniforms.row_stride, invocation);
    if any(place >= uniforms.viewport_size) {
        return;
    }
    let pixel = vec2<i32>(uniforms.viewport_origin + place);
    let depth = textureLoad(depth_texture, pixel, 0);
#ifdef DEPTH_TELLS_GEOMETRY
    // The G-buffer was not cleared: without depth it holds anything.
    let has_geometry = depth != 0.0;
#endif
    let normal_word = textureLoad(normal_texture, pixel, 0).r;
#ifndef DEPTH_TELLS_GEOMETRY
    let has_geometry = normal_word != layout::NO_GEOMETRY;
#endif
    if !has_geometry {
#ifdef OCCLUSION_DEBUG_VIEW
        textureStore(output_texture, pixel, vec4(1.0));
        return;
#endif
        if uniforms.writes_background != 0u {
            textureStore(output_texture, pixel, uniforms.background);
        }
        return;
    }
    textureStore(output_texture, pixel, light(pixel, normal_word, depth));
}
