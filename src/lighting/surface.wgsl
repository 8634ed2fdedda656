// Converts the packed G-buffer to the input of Bevy's lighting functions.
#define_import_path bevy_lean_deferred::lighting::surface

#import bevy_lean_deferred::gbuffer::layout
#import bevy_lean_deferred::lighting::bindings::{normal_texture, surface_texture, uniforms}
#import bevy_lean_deferred::reconstruction::{
    normal::{normal_from_positions, normal_from_slope, straighter_side},
    position::{SMALLEST_DEPTH, ndc_of_fragment, ray_at, view_position},
}
#import bevy_pbr::{
    mesh_types::MESH_FLAGS_SHADOW_RECEIVER_BIT,
    mesh_view_bindings::{depth_prepass_texture as depth_texture, view},
    pbr_functions::calculate_view,
    pbr_types::{PbrInput, STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT, pbr_input_new},
}

#ifdef GBUFFER_VALID_MASK
#import bevy_lean_deferred::lighting::bindings::valid_mask_texture
#endif

#ifdef GBUFFER_EMISSIVE
#import bevy_lean_deferred::gbuffer::layout::light::unpack_light
#import bevy_lean_deferred::lighting::bindings::emissive_texture
#endif

#ifdef GBUFFER_SPECIALIZATION
#import bevy_lean_deferred::gbuffer::layout::specialization
#import bevy_lean_deferred::lighting::bindings::specialization_texture
#import bevy_lean_deferred::shading_models::unlit::unpack_unlit
#ifdef STANDARD_MATERIAL_CLEARCOAT
#import bevy_lean_deferred::shading_models::clearcoat
#endif
#ifdef STANDARD_MATERIAL_ANISOTROPY
#import bevy_lean_deferred::shading_models::anisotropy
#endif
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#import bevy_lean_deferred::shading_models::diffuse_transmission
#endif
#endif

/// G-buffer pixel: the parts that every invocation reads.
struct Pixel {
    /// Position in the render target.
    position: vec2<i32>,
    has_geometry: bool,
    depth: f32,
    surface_word: u32,
    normal_word: u32,
    /// Mask of the optional targets that hold a word of the pixel, with `LIGHTMAP_BITS`.
    valid_mask: u32,
    /// 0, a plain surface, if there is no such word.
    specialization_word: u32,
}

/// Reads the pixel at `place` of the viewport. Outside the viewport it has no geometry.
fn read_pixel(place: vec2<u32>) -> Pixel {
    var pixel: Pixel;
    if any(place >= uniforms.viewport_size) {
        return pixel;
    }
    pixel.position = vec2<i32>(uniforms.viewport_origin + place);
    pixel.depth = textureLoad(depth_texture, pixel.position, 0);
    if uniforms.depth_tells_geometry != 0u && pixel.depth == 0.0 {
        return pixel;
    }
    // Elsewhere depth alone does not decide: forward meshes have depth too, and surfaces at `far` have 0.
    pixel.normal_word = textureLoad(normal_texture, pixel.position, 0).r;
    pixel.has_geometry = pixel.normal_word != layout::NO_GEOMETRY;
    // Without geometry the other words are undefined.
    if !pixel.has_geometry {
        return pixel;
    }
    pixel.surface_word = textureLoad(surface_texture, pixel.position, 0).r;
#ifdef GBUFFER_VALID_MASK
    pixel.valid_mask = textureLoad(valid_mask_texture, pixel.position, 0).r;
#endif
#ifdef GBUFFER_SPECIALIZATION
    if (pixel.valid_mask & layout::SPECIALIZATION_VALID) != 0u {
        pixel.specialization_word = textureLoad(specialization_texture, pixel.position, 0).r;
    }
#endif
    return pixel;
}

/// True if the emissive target holds light of a lightmap.
fn has_lightmap(pixel: Pixel) -> bool {
    return (pixel.valid_mask & layout::LIGHTMAP_BITS) != 0u;
}

/// View-space position of the centre of `pixel`.
fn position_at(pixel: vec2<i32>, depth: f32) -> vec3<f32> {
    let ndc = ndc_of_fragment(vec2<f32>(pixel) + 0.5, view.main_pass_viewport);
    return view_position(view.view_from_clip, vec3(ndc, max(depth, SMALLEST_DEPTH)));
}

#ifdef GEOMETRIC_NORMAL
/// Further from any surface than the tap on the other side can be, so that the other side is chosen.
const OUTSIDE: f32 = 1e9;
/// Largest change of depth's slope from one pixel to the next on one surface: as a share of the slope, and as the tangent of an angle by
/// which a surface that faces the viewer turns.
const BEND_OF_SLOPE: f32 = 0.25;
const BEND_OF_FACING: f32 = 0.1;

/// Neighbours of a pixel, on each axis the one that is nearer to its surface.
struct Neighbours {
    /// -1 for the left and upper one, 1 for the others.
    sides: vec2<f32>,
    depths: vec2<f32>,
    /// False where the surface is one or two pixels wide, or bends sharply.
    are_on_surface: bool,
}

/// Depth at `pixel`; `OUTSIDE` beyond the viewport.
fn depth_at(pixel: vec2<i32>) -> f32 {
    let p = pixel - vec2<i32>(uniforms.viewport_origin);
    if any(p < vec2(0)) || any(p >= vec2<i32>(uniforms.viewport_size)) {
        return OUTSIDE;
    }
    return textureLoad(depth_texture, pixel, 0);
}

fn neighbours_of(pixel: vec2<i32>, depth: f32) -> Neighbours {
    let x = vec2(1, 0);
    let y = vec2(0, 1);
    // Left and upper, right and lower.
    let near_a = vec2(depth_at(pixel - x), depth_at(pixel - y));
    let near_b = vec2(depth_at(pixel + x), depth_at(pixel + y));
    let far_a = vec2(depth_at(pixel - 2 * x), depth_at(pixel - 2 * y));
    let far_b = vec2(depth_at(pixel + 2 * x), depth_at(pixel + 2 * y));
    var found: Neighbours;
    found.sides = vec2(
        straighter_side(depth, near_a.x, far_a.x, near_b.x, far_b.x),
        straighter_side(depth, near_a.y, far_a.y, near_b.y, far_b.y),
    );
    let is_after = found.sides > vec2(0.0);
    found.depths = select(near_a, near_b, is_after);
    let bends = abs(2.0 * found.depths - select(far_a, far_b, is_after) - depth);
    let most = BEND_OF_SLOPE * abs(found.depths - depth) + BEND_OF_FACING * depth_step(depth);
    found.are_on_surface = all(bends <= most);
    return found;
}

/// Change of depth from one pixel to the next on a surface at 45° to the view axis.
fn depth_step(depth: f32) -> f32 {
    let is_orthographic = view.clip_from_view[3].w == 1.0;
    let per_pixel = 2.0 * abs(view.view_from_clip[1].y) / view.main_pass_viewport.w;
    return per_pixel * select(depth, abs(view.clip_from_view[2].z), is_orthographic);
}

/// World-space normal of the surface at `pixel`, unit length, facing the viewer. `depth` is the pixel's.
fn world_geometric_normal(pixel: vec2<i32>, depth: f32) -> vec3<f32> {
    return normal_among(pixel, depth, neighbours_of(pixel, depth));
}

fn normal_among(pixel: vec2<i32>, depth: f32, found: Neighbours) -> vec3<f32> {
    // The camera may be scaled: normals transform by the inverse transpose.
    return normalize((vec4(view_normal_among(pixel, depth, found), 0.0) * view.view_from_world).xyz);
}

/// Normal for the bias of shadow maps where the shading normal `N` is not the mesh's: that of the surface in depth, if that shows it.
fn shadow_normal(pixel: vec2<i32>, depth: f32, N: vec3<f32>) -> vec3<f32> {
    let found = neighbours_of(pixel, depth);
    if !found.are_on_surface {
        return N;
    }
    return normal_among(pixel, depth, found);
}

fn view_normal_among(pixel: vec2<i32>, depth: f32, found: Neighbours) -> vec3<f32> {
#ifdef PROJECTION_IS_AFFINE
    let slope = select((found.depths - depth) * found.sides, vec2(0.0), found.depths == vec2(OUTSIDE));
    let viewport = view.main_pass_viewport;
    let ndc = ndc_of_fragment(vec2<f32>(pixel) + 0.5, viewport);
    let per_ndc = slope * viewport.zw * vec2(0.5, -0.5);
    let m = view.view_from_clip;
    return normal_from_slope(m, ray_at(m, ndc), depth, per_ndc / vec2(m[0][0], m[1][1]));
#else
    let position = position_at(pixel, depth);
    let sides = vec2<i32>(found.sides);
    let n = normal_from_positions(
        position,
        position_at(pixel + vec2(sides.x, 0), found.depths.x), found.sides.x,
        position_at(pixel + vec2(0, sides.y), found.depths.y), found.sides.y,
    );
    // A mirrored projection reverses the order of the taps, and thus the normal.
    let to_viewer = select(-position, vec3(0.0, 0.0, 1.0), view.clip_from_view[3].w == 1.0);
    return select(n, -n, dot(n, to_viewer) < 0.0);
#endif
}
#endif  // GEOMETRIC_NORMAL

/// True if lights affect the surface.
fn is_lit(pixel: Pixel) -> bool {
#ifdef GBUFFER_SPECIALIZATION
    return !is_unlit(pixel.specialization_word);
#else
    return true;
#endif
}

/// True if the surface is lit, and may be in shadow.
fn receives_shadows(pixel: Pixel) -> bool {
#ifdef GBUFFER_SPECIALIZATION
    return is_lit(pixel) && (pixel.specialization_word & specialization::NO_SHADOWS) == 0u;
#else
    return true;
#endif
}

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
/// True if light on the back is transmitted and may be in shadow. The surface receives shadows.
fn back_receives_shadows(pixel: Pixel) -> bool {
    let word = pixel.specialization_word;
    return specialization::unpack_shading_model(word) == specialization::DIFFUSE_TRANSMISSION
        && diffuse_transmission::unpack_receives_shadows(specialization::unpack_arguments(word));
}

/// Distance in metres between the surface and its back, where it transmits light.
fn thickness_of(pixel: Pixel) -> f32 {
    return diffuse_transmission::unpack_thickness(specialization::unpack_arguments(pixel.specialization_word));
}
#endif

fn pbr_input_from_gbuffer(pixel: Pixel) -> PbrInput {
    let surface_word = pixel.surface_word;
    let position = position_at(pixel.position, pixel.depth);

    var pbr = pbr_input_new();
    pbr.material.base_color = vec4(layout::unpack_albedo(surface_word), 1.0);
    pbr.material.metallic = layout::unpack_metallic(surface_word);
    pbr.material.perceptual_roughness = layout::unpack_roughness(pixel.normal_word);
    // Weight 0: stored emission is exposed already, and that of decals is not to be exposed.
    pbr.material.emissive = vec4(0.0);
    pbr.material.flags = STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT;
    pbr.diffuse_occlusion = vec3(layout::unpack_occlusion(surface_word));
    pbr.frag_coord = vec4(vec2<f32>(pixel.position) + 0.5, pixel.depth, 1.0);
    pbr.world_position = vec4((view.world_from_view * vec4(position, 1.0)).xyz, 1.0);
    pbr.is_orthographic = view.clip_from_view[3].w == 1.0;
    pbr.V = calculate_view(pbr.world_position, pbr.is_orthographic);
    pbr.N = layout::unpack_normal(pixel.normal_word);
    // Placeholder: geometric normals are computed where they are needed.
    pbr.world_normal = pbr.N;
#ifdef SHADOWS
    pbr.flags = MESH_FLAGS_SHADOW_RECEIVER_BIT;
#endif
#ifdef GBUFFER_SPECIALIZATION
    specialize(&pbr, pixel.specialization_word);
#endif
#ifdef GBUFFER_EMISSIVE
    var light = vec3(0.0);
    if (pixel.valid_mask & layout::EMISSIVE_VALID) != 0u {
        light = unpack_light(textureLoad(emissive_texture, pixel.position, 0).r);
    }
#ifdef LIGHTMAPPED_SURFACES
    // Divided by exposure, because Bevy exposes the light of lightmaps.
    if (pixel.valid_mask & layout::LIGHTMAP_BITS) == layout::LIGHTMAP_INCIDENT {
        pbr.lightmap_light = light / view.exposure;
    } else {
        pbr.material.emissive = vec4(light, 0.0);
    }
#else
    pbr.material.emissive = vec4(light, 0.0);
#endif
#endif  // GBUFFER_EMISSIVE
    return pbr;
}

#ifdef GBUFFER_SPECIALIZATION
fn is_unlit(word: u32) -> bool {
    return specialization::unpack_shading_model(word) == specialization::UNLIT;
}

fn specialize(pbr: ptr<function, PbrInput>, word: u32) {
    if (word & specialization::NO_FOG) != 0u {
        (*pbr).material.flags = 0u;
    }
    if is_unlit(word) {
        (*pbr).material.base_color = vec4(unpack_unlit(word), 1.0);
        return;
    }
    (*pbr).material.reflectance = vec3(specialization::unpack_reflectance(word));
#ifdef SHADOWS
    if (word & specialization::NO_SHADOWS) != 0u {
        (*pbr).flags = 0u;
    }
#endif

    let arguments = specialization::unpack_arguments(word);
    switch specialization::unpack_shading_model(word) {
#ifdef STANDARD_MATERIAL_CLEARCOAT
        case specialization::CLEARCOAT: { clearcoat::specialize(pbr, arguments); }
#endif
#ifdef STANDARD_MATERIAL_ANISOTROPY
        case specialization::ANISOTROPY: { anisotropy::specialize(pbr, arguments); }
#endif
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
        case specialization::DIFFUSE_TRANSMISSION: { diffuse_transmission::specialize(pbr, arguments); }
#endif
        default: {}
    }
}
#endif  // GBUFFER_SPECIALIZATION
