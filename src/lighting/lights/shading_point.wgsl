// A point on a surface, with the terms that all lights share.
#define_import_path bevy_lean_deferred::lighting::lights::shading_point

#import bevy_pbr::{
    lighting::{F_AB, perceptualRoughnessToRoughness},
    mesh_types::{MESH_FLAGS_SHADOW_RECEIVER_BIT, MESH_FLAGS_TRANSMITTED_SHADOW_RECEIVER_BIT},
    pbr_functions::{calculate_F0, calculate_F0_dielectric, calculate_diffuse_color},
    pbr_types::{PbrInput, StandardMaterial},
}

#ifndef FORWARD_MESH
#import bevy_lean_deferred::lighting::surface::Pixel
#ifdef GEOMETRIC_NORMAL
#import bevy_lean_deferred::gbuffer::layout::{pack_direction, unpack_direction, unpack_has_mesh_normal}
#import bevy_lean_deferred::lighting::parts
#import bevy_lean_deferred::lighting::surface::shadow_normal
#endif
#ifdef LIGHTMAPPED_SURFACES
#import bevy_lean_deferred::lighting::surface::has_lightmap
#endif
#ifdef GBUFFER_SPECIALIZATION
#import bevy_lean_deferred::gbuffer::layout::specialization
#endif
#endif

/// Cluster of pixels that no light reaches.
const NO_CLUSTER: u32 = 0xffffffffu;

/// Directions are unit vectors in world space.
struct ShadingPoint {
    pixel: vec2<i32>,
    depth: f32,
    position: vec3<f32>,
    view_z: f32,
    N: vec3<f32>,
    /// Direction to the viewer.
    V: vec3<f32>,
    /// N·V before clamping: may be negative, or above 1 by rounding.
    signed_NdotV: f32,
    /// Square of `perceptual_roughness`, clamped like Bevy's.
    roughness: f32,
    perceptual_roughness: f32,
    // Terms that loops over lights do not read: see `set_material`.
    /// N·V, 0.0001 to 1.
    NdotV: f32,
    metallic: f32,
    F0_dielectric: vec3<f32>,
    F0_metallic: vec3<f32>,
    F_ab: vec2<f32>,
    diffuse_color: vec3<f32>,
    F_normal: vec3<f32>,
    F_grazing: f32,
    /// Factor of specular reflection that adds multiple scattering.
    multiscatter: vec3<f32>,
    /// Light that is scattered again, per light that is reflected at a reflectance of 1.
    scattered_again: f32,
    receives_shadows: bool,
#ifdef GEOMETRIC_NORMAL
#ifdef FORWARD_MESH
    /// Interpolated, as Bevy has it: not of unit length.
    geometric_normal: vec3<f32>,
#else
    /// Packed, so that loops over lights keep one register; 0 if it is not computed yet.
    geometric_normal_word: u32,
#endif
#endif
#ifdef LIGHTMAPPED_SURFACES
    is_lightmapped: bool,
#endif
#ifdef STANDARD_MATERIAL_CLEARCOAT
    /// 0 without a coat. The coat's normal is `N`.
    clearcoat: f32,
    clearcoat_perceptual_roughness: f32,
    clearcoat_roughness: f32,
#endif
#ifdef STANDARD_MATERIAL_ANISOTROPY
    is_anisotropic: bool,
    anisotropy: f32,
    tangent: vec3<f32>,
#ifdef FORWARD_MESH
    bitangent: vec3<f32>,
#else
#ifdef CLUSTERED_DECALS_ARE_USABLE
    bitangent: vec3<f32>,
#endif
#endif
#endif
#ifdef SHADING_MODEL_RIM
    has_rim_light: bool,
#endif
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    transmits: bool,
    /// A colour as above. 0 where no light is transmitted.
    transmitted_color: vec3<f32>,
    /// In metres.
    thickness: f32,
    back_receives_shadows: bool,
#endif
}

fn fifth_power(x: f32) -> f32 {
    let square = x * x;
    return square * square * x;
}

/// One direction's factor of the visibility of microfacets (Heitz 2014, "Understanding the Masking-Shadowing Function in
/// Microfacet-Based BRDFs"), from its cosine.
fn smith(roughness: f32, cosine: f32) -> f32 {
    let square = roughness * roughness;
    return sqrt((cosine - square * cosine) * cosine + square);
}

/// N·V, 0.0001 to 1.
fn view_cosine(point: ptr<function, ShadingPoint>) -> f32 {
    // Bevy has no upper bound, but roots and powers of 1 - N·V are NaN for N·V above 1.
    return clamp((*point).signed_NdotV, 0.0001, 1.0);
}

/// (1 - N·V)⁵
fn view_fresnel(point: ptr<function, ShadingPoint>) -> f32 {
    return fifth_power(1.0 - view_cosine(point));
}

/// The terms that follow from `pbr` alone, but for those of `set_material`.
fn common_terms(pbr: PbrInput, view_z: f32) -> ShadingPoint {
    let material = pbr.material;
    var point: ShadingPoint;
    point.position = pbr.world_position.xyz;
    point.view_z = view_z;
    point.N = pbr.N;
    point.V = pbr.V;
    point.signed_NdotV = dot(pbr.N, pbr.V);
    point.roughness = perceptualRoughnessToRoughness(material.perceptual_roughness);
    point.perceptual_roughness = material.perceptual_roughness;
    point.receives_shadows = (pbr.flags & MESH_FLAGS_SHADOW_RECEIVER_BIT) != 0u;
#ifdef STANDARD_MATERIAL_CLEARCOAT
    point.clearcoat = material.clearcoat;
    point.clearcoat_perceptual_roughness = material.clearcoat_perceptual_roughness;
    point.clearcoat_roughness = perceptualRoughnessToRoughness(material.clearcoat_perceptual_roughness);
#endif
#ifdef STANDARD_MATERIAL_ANISOTROPY
    point.anisotropy = pbr.anisotropy_strength;
    point.tangent = pbr.anisotropy_T;
#ifdef FORWARD_MESH
    point.bitangent = pbr.anisotropy_B;
#else
#ifdef CLUSTERED_DECALS_ARE_USABLE
    point.bitangent = pbr.anisotropy_B;
#endif
#endif
#endif
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    point.transmits = any(transmitted_color_of(material) != vec3(0.0));
    point.thickness = material.thickness;
    point.back_receives_shadows = point.receives_shadows
        && (pbr.flags & MESH_FLAGS_TRANSMITTED_SHADOW_RECEIVER_BIT) != 0u;
#endif
    return point;
}

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
fn transmitted_color_of(material: StandardMaterial) -> vec3<f32> {
    return material.base_color.rgb * (1.0 - material.metallic) * material.diffuse_transmission;
}
#endif

/// Sets the terms of the surface that loops over point, spot and directional lights do not read.
fn set_material(point: ptr<function, ShadingPoint>, material: StandardMaterial) {
    (*point).metallic = material.metallic;
    (*point).F0_dielectric = calculate_F0_dielectric(material.reflectance);
    (*point).F0_metallic = material.base_color.rgb;
    (*point).NdotV = view_cosine(point);
    (*point).F_ab = F_AB(material.perceptual_roughness, (*point).NdotV);
    (*point).scattered_again = 1.0 / ((*point).F_ab.x + (*point).F_ab.y) - 1.0;
    (*point).diffuse_color = calculate_diffuse_color(
        material.base_color.rgb,
        material.metallic,
        0.0,
        material.diffuse_transmission,
    );
    let F_normal = calculate_F0(material.base_color.rgb, material.metallic, material.reflectance);
    (*point).F_normal = F_normal;
    // A reflectance below that of any real surface also lowers reflection at grazing angles.
    (*point).F_grazing = saturate(dot(F_normal, vec3(50.0 * 0.33)));
    (*point).multiscatter = 1.0 + F_normal * (*point).scattered_again;
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    (*point).transmitted_color = transmitted_color_of(material);
#endif
}

#ifdef FORWARD_MESH
/// A point on a mesh that Bevy's passes draw: the pipeline is compiled for its material alone, and its normal is interpolated.
fn shading_point(pbr: PbrInput, view_z: f32) -> ShadingPoint {
    var point = common_terms(pbr, view_z);
    point.pixel = vec2<i32>(pbr.frag_coord.xy);
    point.depth = pbr.frag_coord.z;
#ifdef GEOMETRIC_NORMAL
    point.geometric_normal = pbr.world_normal;
#endif
#ifdef LIGHTMAPPED_SURFACES
    point.is_lightmapped = true;
#endif
#ifdef STANDARD_MATERIAL_ANISOTROPY
    point.is_anisotropic = true;
#endif
    return point;
}
#else   // FORWARD_MESH
/// A point on the surface at a pixel of the G-buffer.
fn shading_point(pbr: PbrInput, pixel: Pixel, view_z: f32) -> ShadingPoint {
    var point = common_terms(pbr, view_z);
    point.pixel = pixel.position;
    point.depth = pixel.depth;
#ifdef GEOMETRIC_NORMAL
    if unpack_has_mesh_normal(pixel.surface_word) {
        // Decals change `pbr.N` alone.
        point.geometric_normal_word = pack_direction(pbr.world_normal);
    }
#endif
#ifdef LIGHTMAPPED_SURFACES
    point.is_lightmapped = has_lightmap(pixel);
#endif
#ifdef GBUFFER_SPECIALIZATION
    let model = specialization::unpack_shading_model(pixel.specialization_word);
#endif
#ifdef SHADING_MODEL_RIM
    point.has_rim_light = model == specialization::RIM;
#endif
#ifdef STANDARD_MATERIAL_ANISOTROPY
    point.is_anisotropic = model == specialization::ANISOTROPY;
#endif
    return point;
}
#endif  // FORWARD_MESH

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
fn transmits(point: ptr<function, ShadingPoint>) -> bool {
    return (*point).transmits;
}

/// Point where light from behind enters a surface that transmits light.
fn back_position(point: ptr<function, ShadingPoint>) -> vec3<f32> {
    return (*point).position - geometric_normal(point) * (*point).thickness;
}
#endif

#ifdef STANDARD_MATERIAL_ANISOTROPY
/// As `anisotropy::specialize` sets it, so that no registers keep it. Decals turn the normal only.
fn bitangent_at(point: ptr<function, ShadingPoint>) -> vec3<f32> {
#ifdef FORWARD_MESH
    return (*point).bitangent;
#else
#ifdef CLUSTERED_DECALS_ARE_USABLE
    return (*point).bitangent;
#else
    return cross((*point).N, (*point).tangent);
#endif
#endif
}
#endif

#ifdef FORWARD_MESH
fn geometric_normal(point: ptr<function, ShadingPoint>) -> vec3<f32> {
#ifdef GEOMETRIC_NORMAL
    return (*point).geometric_normal;
#else
    return (*point).N;
#endif
}
#else ifdef GEOMETRIC_NORMAL
/// Evaluated lazily: in many pixels no light with shadows reaches the surface. The shading normal where nothing casts shadows.
fn geometric_normal(point: ptr<function, ShadingPoint>) -> vec3<f32> {
    if !parts::has(parts::SHADOW_MAPS) {
        return (*point).N;
    }
    if (*point).geometric_normal_word == 0u {
        (*point).geometric_normal_word = pack_direction(shadow_normal((*point).pixel, (*point).depth, (*point).N));
    }
    return unpack_direction((*point).geometric_normal_word);
}
#else
/// Shading normal, because nothing casts shadows.
fn geometric_normal(point: ptr<function, ShadingPoint>) -> vec3<f32> {
    return (*point).N;
}
#endif
