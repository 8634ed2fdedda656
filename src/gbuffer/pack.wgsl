// Packs materials into the G-buffer, for their fragment shaders.
#define_import_path bevy_lean_deferred::gbuffer::pack

#import bevy_lean_deferred::gbuffer::layout::{
    EMISSIVE_VALID, MOTION_VALID, SPECIALIZATION_VALID, Surface, VISIBILITY_MASK_VALID,
    pack,
}
#import bevy_pbr::{
    mesh_view_bindings::view,
    pbr_functions::alpha_discard,
    pbr_types::PbrInput,
    prepass_io::VertexOutput,
}

#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither
#endif

#ifdef GBUFFER_EMISSIVE
#import bevy_lean_deferred::gbuffer::layout::light::pack_light
#ifdef LIGHTMAP
#import bevy_lean_deferred::gbuffer::layout::{LIGHTMAP_INCIDENT, LIGHTMAP_REFLECTED}
#import bevy_pbr::pbr_functions::calculate_diffuse_color
#endif
#endif

#ifdef GBUFFER_SPECIALIZATION
#import bevy_lean_deferred::gbuffer::layout::specialization as special
#import bevy_lean_deferred::shading_models::unlit::pack_unlit
#ifdef STANDARD_MATERIAL_CLEARCOAT
#import bevy_lean_deferred::shading_models::clearcoat
#else ifdef STANDARD_MATERIAL_ANISOTROPY
#import bevy_lean_deferred::shading_models::anisotropy
#else ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#import bevy_lean_deferred::shading_models::diffuse_transmission
#endif
#import bevy_pbr::{
    mesh_types::MESH_FLAGS_SHADOW_RECEIVER_BIT,
    pbr_types::{STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT, STANDARD_MATERIAL_FLAGS_UNLIT_BIT},
}
#endif

#ifdef GBUFFER_MOTION
#import bevy_lean_deferred::gbuffer::layout::motion::{motion_between, pack_motion}
#import bevy_pbr::prepass_bindings::previous_view_uniforms
#endif

#ifdef GBUFFER_VISIBILITY_MASK
/// Visibility mask of the meshes of this draw.
@group(1) @binding(0) var<uniform> mesh_visibility_mask: u32;
#endif

/// Targets of the G-buffer: the two base targets and, in passes with optional targets, those that the mesh writes and a mask of
/// them and of their content.
struct GBufferOutput {
    @location(0) surface: u32,
    @location(1) normal: u32,
#ifdef GBUFFER_VALID_MASK
    @location(2) valid_mask: u32,
#endif
#ifdef GBUFFER_EMISSIVE
    @location(3) emissive: u32,
#endif
#ifdef GBUFFER_SPECIALIZATION
    @location(4) specialization: u32,
#endif
#ifdef GBUFFER_MOTION
    @location(5) motion: u32,
#endif
#ifdef GBUFFER_VISIBILITY_MASK
    @location(6) visibility_mask: u32,
#endif
}

#ifdef GBUFFER_VALID_MASK
fn valid_mask(pbr: PbrInput) -> u32 {
    var mask = 0u;
#ifdef GBUFFER_EMISSIVE
    mask |= EMISSIVE_VALID;
#ifdef LIGHTMAP
    // Incident and emitted light stay apart where possible, because decals change the part of lightmaps that a surface reflects.
    mask |= select(LIGHTMAP_INCIDENT, LIGHTMAP_REFLECTED, emits(pbr));
#endif
#endif
#ifdef GBUFFER_SPECIALIZATION
    mask |= SPECIALIZATION_VALID;
#endif
#ifdef GBUFFER_MOTION
    mask |= MOTION_VALID;
#endif
#ifdef GBUFFER_VISIBILITY_MASK
    mask |= VISIBILITY_MASK_VALID;
#endif
    return mask;
}
#endif

#ifdef GBUFFER_AT_DEPTH
/// Factor of the cutoff where depth was drawn before: what depth has kept is kept, whatever either shader rounds.
const KEPT: f32 = 0.9999;
#endif

/// Discards fragments by alpha mask and by the crossfade of visibility ranges.
fn apply_discards(in: VertexOutput, pbr_input: ptr<function, PbrInput>) {
#ifdef VISIBILITY_RANGE_DITHER
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif
#ifdef GBUFFER_AT_DEPTH
    (*pbr_input).material.alpha_cutoff *= KEPT;
#endif
    (*pbr_input).material.base_color =
        alpha_discard((*pbr_input).material, (*pbr_input).material.base_color);
}

/// Distance of unit normals that count as the same: 2.6°.
const SAME_NORMAL: f32 = 0.045;
/// Normals from depth are chosen only where they are this much nearer: neighbours may be of other triangles.
const PREFERENCE: f32 = 2.0;

/// True if the shading normal tells the mesh's better than depth does, which tells that of triangles.
fn has_mesh_normal(pbr: PbrInput, in: VertexOutput) -> bool {
    let n = normalize(pbr.world_normal);
    let across = cross(dpdx(in.world_position.xyz), dpdy(in.world_position.xyz));
    let triangle = across * inverseSqrt(max(dot(across, across), 1e-30));
    let of_depth = length(n - select(triangle, -triangle, dot(triangle, n) < 0.0)) + length(fwidth(n));
    return length(pbr.N - n) <= max(SAME_NORMAL, PREFERENCE * of_depth);
}

/// Packs the content of this pass's targets. From `pbr`: base colour, metallic, roughness, shading normal and occlusion; where
/// written, emitted light, the further properties of a `StandardMaterial` and the mesh's visibility mask. From `in`: motion.
fn pack_pbr_input(pbr: PbrInput, in: VertexOutput) -> GBufferOutput {
    var out: GBufferOutput;
    let words = pack(Surface(
        pbr.material.base_color.rgb,
        pbr.material.metallic,
        // The occlusion texture has one channel, so all three are equal here.
        pbr.diffuse_occlusion.r,
        pbr.N,
        pbr.material.perceptual_roughness,
        has_mesh_normal(pbr, in),
    ));
    out.surface = words.x;
    out.normal = words.y;
#ifdef GBUFFER_VALID_MASK
    out.valid_mask = valid_mask(pbr);
#endif
#ifdef GBUFFER_EMISSIVE
    out.emissive = pack_light(stored_light(pbr));
#endif
#ifdef GBUFFER_SPECIALIZATION
    out.specialization = specialization_word(pbr, words.y);
#endif
#ifdef GBUFFER_MOTION
    out.motion = motion_word(in);
#endif
#ifdef GBUFFER_VISIBILITY_MASK
    out.visibility_mask = mesh_visibility_mask;
#endif
    return out;
}

#ifdef GBUFFER_MOTION
/// Motion since the last frame. Only meshes that move or deform write it; that of others follows from depth.
fn motion_word(in: VertexOutput) -> u32 {
    return pack_motion(motion_between(
        view.unjittered_clip_from_world * in.world_position,
        previous_view_uniforms.clip_from_world * in.previous_world_position,
    ));
}
#endif

#ifdef GBUFFER_SPECIALIZATION
/// Like `pack_pbr_input`, with a shading model that `StandardMaterial` lacks, and its packed arguments.
fn pack_shading_model(
    pbr: PbrInput,
    in: VertexOutput,
    shading_model: u32,
    arguments: u32,
) -> GBufferOutput {
    var out = pack_pbr_input(pbr, in);
    let reflectance = pbr.material.reflectance.g;
    let word = special::pack_specialization(reflectance, shading_model, flags(pbr));
    out.specialization = special::with_arguments(word, arguments);
    return out;
}
#endif

#ifdef GBUFFER_EMISSIVE
/// Emitted light. `emissive.a` is the weight of the camera's exposure.
fn emitted_light(pbr: PbrInput) -> vec3<f32> {
    return pbr.material.emissive.rgb * mix(1.0, view.exposure, pbr.material.emissive.a);
}

fn stored_light(pbr: PbrInput) -> vec3<f32> {
    let emitted = emitted_light(pbr);
#ifdef LIGHTMAP
    let incident = pbr.lightmap_light * view.exposure;
    if emits(pbr) {
        return emitted + incident * calculate_diffuse_color(
            pbr.material.base_color.rgb,
            pbr.material.metallic,
            pbr.material.specular_transmission,
            pbr.material.diffuse_transmission,
        );
    }
    return incident;
#else
    return emitted;
#endif
}
#endif  // GBUFFER_EMISSIVE

#ifdef LIGHTMAP
fn emits(pbr: PbrInput) -> bool {
    return any(pbr.material.emissive.rgb != vec3(0.0));
}
#endif

#ifdef GBUFFER_SPECIALIZATION
fn flags(pbr: PbrInput) -> u32 {
    let has_fog = (pbr.material.flags & STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT) != 0u;
    let has_shadows = (pbr.flags & MESH_FLAGS_SHADOW_RECEIVER_BIT) != 0u;
    var flags = select(special::NO_FOG, 0u, has_fog);
    flags |= select(special::NO_SHADOWS, 0u, has_shadows);
    return flags;
}

fn specialization_word(pbr: PbrInput, normal_word: u32) -> u32 {
    let flags = flags(pbr);
    if (pbr.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) != 0u {
        return pack_unlit(pbr.material.base_color.rgb, flags);
    }
    // Only untinted materials get here: the channels are equal.
    let reflectance = pbr.material.reflectance.g;
#ifdef STANDARD_MATERIAL_CLEARCOAT
    let word = special::pack_specialization(reflectance, special::CLEARCOAT, flags);
    return special::with_arguments(word, clearcoat::arguments_of(pbr, normal_word));
#else ifdef STANDARD_MATERIAL_ANISOTROPY
    let word = special::pack_specialization(reflectance, special::ANISOTROPY, flags);
    return special::with_arguments(word, anisotropy::arguments_of(pbr, normal_word));
#else ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    let word = special::pack_specialization(reflectance, special::DIFFUSE_TRANSMISSION, flags);
    return special::with_arguments(word, diffuse_transmission::arguments_of(pbr, normal_word));
#else
    return special::pack_specialization(reflectance, special::PLAIN, flags);
#endif
}
#endif  // GBUFFER_SPECIALIZATION
