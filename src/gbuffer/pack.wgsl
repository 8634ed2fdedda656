// From a material to the packed G-buffer, for the fragment shaders of materials.
#define_import_path bevy_lean_deferred::gbuffer::pack

#import bevy_lean_deferred::gbuffer::layout::{Surface, pack, unpack_normal}
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
#import bevy_lean_deferred::gbuffer::layout::emissive::pack_emissive
#ifdef LIGHTMAP
#import bevy_pbr::pbr_functions::calculate_diffuse_color
#endif
#endif

#ifdef GBUFFER_SPECIALIZATION
#import bevy_lean_deferred::gbuffer::layout::specialization as special
#import bevy_pbr::{
    mesh_types::{MESH_FLAGS_SHADOW_RECEIVER_BIT, MESH_FLAGS_TRANSMITTED_SHADOW_RECEIVER_BIT},
    pbr_types::{STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT, STANDARD_MATERIAL_FLAGS_UNLIT_BIT},
}
#endif

#ifdef GBUFFER_MOTION
#import bevy_lean_deferred::gbuffer::layout::motion::{INVALID_MOTION, motion_between, pack_motion}
#ifdef MOTION_VECTOR_PREPASS
#import bevy_pbr::prepass_bindings::previous_view_uniforms
#endif
#endif

/// The targets of the G-buffer: two of the base, and those that are optional.
struct GBufferOutput {
    @location(0) surface: u32,
    @location(1) normal: u32,
#ifdef GBUFFER_EMISSIVE
    @location(2) emissive: u32,
#endif
#ifdef GBUFFER_SPECIALIZATION
    @location(3) specialization: u32,
#endif
#ifdef GBUFFER_MOTION
    @location(4) motion: u32,
#endif
#ifdef GBUFFER_VISIBILITY_MASK
    @location(5) visibility_mask: u32,
#endif
}

/// Discards fragments that the alpha mask or a visibility range's crossfade leave out.
fn apply_discards(in: VertexOutput, pbr_input: ptr<function, PbrInput>) {
#ifdef VISIBILITY_RANGE_DITHER
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif
    (*pbr_input).material.base_color =
        alpha_discard((*pbr_input).material, (*pbr_input).material.base_color);
}

/// Packs what the targets of this pass carry of `in`: base colour, metallic, roughness, shading normal and occlusion,
/// and where they are written, emitted light, what a `StandardMaterial` may have beyond these, and the layers of the
/// mesh. The surface does not move, unless `with_motion` says otherwise.
fn pack_pbr_input(in: PbrInput) -> GBufferOutput {
    var out: GBufferOutput;
    let words = pack(Surface(
        in.material.base_color.rgb,
        in.material.metallic,
        // The occlusion texture has one channel; all three are equal here.
        in.diffuse_occlusion.r,
        in.N,
        in.material.perceptual_roughness,
    ));
    out.surface = words.x;
    out.normal = words.y;
#ifdef GBUFFER_EMISSIVE
    out.emissive = pack_emissive(stored_light(in));
#endif
#ifdef GBUFFER_SPECIALIZATION
    out.specialization = specialization_word(in, words.y);
#endif
#ifdef GBUFFER_MOTION
    out.motion = INVALID_MOTION;
#endif
#ifdef GBUFFER_VISIBILITY_MASK
    out.visibility_mask = #{MESH_VISIBILITY_MASK}u;
#endif
    return out;
}

/// Adds where the surface was in the last frame, if the mesh moves or deforms. The others' motion follows from depth.
fn with_motion(out: GBufferOutput, in: VertexOutput) -> GBufferOutput {
    var moved = out;
#ifdef GBUFFER_MOTION
#ifdef MOTION_VECTOR_PREPASS
    moved.motion = pack_motion(motion_between(
        view.unjittered_clip_from_world * in.world_position,
        previous_view_uniforms.clip_from_world * in.previous_world_position,
    ));
#endif
#endif
    return moved;
}

#ifdef GBUFFER_SPECIALIZATION
/// As `pack_pbr_input`, with a shading model that a `StandardMaterial` does not have, and its packed arguments.
fn pack_shading_model(in: PbrInput, shading_model: u32, arguments: u32) -> GBufferOutput {
    var out = pack_pbr_input(in);
    let reflectance = in.material.reflectance.g;
    let word = special::pack_specialization(reflectance, shading_model, flags(in));
    out.specialization = special::with_arguments(word, arguments);
    return out;
}
#endif

#ifdef GBUFFER_EMISSIVE
/// Light as the camera is exposed to it.
fn emitted_light(in: PbrInput) -> vec3<f32> {
    return in.material.emissive.rgb * mix(1.0, view.exposure, in.material.emissive.a);
}

fn stored_light(in: PbrInput) -> vec3<f32> {
    let emitted = emitted_light(in);
#ifdef LIGHTMAP
    let incident = in.lightmap_light * view.exposure;
    if emits(in) {
        return emitted + incident * calculate_diffuse_color(
            in.material.base_color.rgb,
            in.material.metallic,
            in.material.specular_transmission,
            in.material.diffuse_transmission,
        );
    }
    return incident;
#else
    return emitted;
#endif
}
#endif  // GBUFFER_EMISSIVE

#ifdef LIGHTMAP
fn emits(in: PbrInput) -> bool {
    return any(in.material.emissive.rgb != vec3(0.0));
}
#endif

#ifdef GBUFFER_SPECIALIZATION
fn flags(in: PbrInput) -> u32 {
    let has_fog = (in.material.flags & STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT) != 0u;
    let has_shadows = (in.flags & MESH_FLAGS_SHADOW_RECEIVER_BIT) != 0u;
    var flags = select(special::NO_FOG, 0u, has_fog);
    flags |= select(special::NO_SHADOWS, 0u, has_shadows);
#ifdef LIGHTMAP
    // Kept apart where that is possible: decals change what a surface reflects of a lightmap.
    flags |= select(special::LIGHTMAP_INCIDENT, special::LIGHTMAP_REFLECTED, emits(in));
#endif
    return flags;
}

fn specialization_word(in: PbrInput, normal_word: u32) -> u32 {
    let flags = flags(in);
    if (in.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) != 0u {
        return special::pack_unlit(
            in.material.base_color.rgb,
            special::UNLIT,
            flags,
        );
    }
    // Only materials without a tint are here: the channels are equal.
    let reflectance = in.material.reflectance.g;
#ifdef STANDARD_MATERIAL_CLEARCOAT
    return special::with_arguments(
        special::pack_specialization(reflectance, special::CLEARCOAT, flags),
        special::pack_clearcoat(
            in.material.clearcoat,
            in.material.clearcoat_perceptual_roughness,
        ),
    );
#else ifdef STANDARD_MATERIAL_ANISOTROPY
    return special::with_arguments(
        special::pack_specialization(reflectance, special::ANISOTROPY, flags),
        special::pack_anisotropy(
            in.anisotropy_strength,
            in.anisotropy_T,
            unpack_normal(normal_word),
        ),
    );
#else ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    return special::with_arguments(
        special::pack_specialization(reflectance, special::BACKLIGHT, flags),
        special::pack_backlight(
            in.material.diffuse_transmission,
            in.material.thickness,
            (in.flags & MESH_FLAGS_TRANSMITTED_SHADOW_RECEIVER_BIT) != 0u,
        ),
    );
#else
    return special::pack_specialization(reflectance, special::PLAIN, flags);
#endif
}
#endif  // GBUFFER_SPECIALIZATION
