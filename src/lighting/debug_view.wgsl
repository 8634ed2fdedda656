// Debug views: a channel of the G-buffer in place of light.
#define_import_path bevy_lean_deferred::lighting::debug_view

#import bevy_lean_deferred::lighting::surface::Pixel
#import bevy_pbr::{mesh_view_bindings::view, pbr_types::PbrInput}

#ifdef DEBUG_SHADING_MODEL
#import bevy_lean_deferred::gbuffer::layout::specialization
#endif

#ifdef DEBUG_GEOMETRIC_NORMAL
#import bevy_lean_deferred::lighting::surface::world_geometric_normal
#endif

#ifdef DEBUG_MOTION
#ifdef GBUFFER_MOTION
#import bevy_lean_deferred::gbuffer::layout
#import bevy_lean_deferred::gbuffer::layout::motion
#import bevy_lean_deferred::lighting::bindings::motion_texture
#endif
#endif

#ifdef DEBUG_VISIBILITY_MASK
#ifdef GBUFFER_VISIBILITY_MASK
#import bevy_lean_deferred::gbuffer::layout
#import bevy_lean_deferred::lighting::bindings::visibility_mask_texture
#endif
#endif

#ifdef DEBUG_SHADING_MODEL
/// Grey for plain surfaces: black at a specular constant of 0, white at 2.
fn shading_model_color(word: u32) -> vec3<f32> {
    switch specialization::unpack_shading_model(word) {
        case specialization::SUBSURFACE: { return vec3(0.9, 0.4, 0.3); }
        case specialization::ANISOTROPY: { return vec3(0.9, 0.8, 0.1); }
        case specialization::RIM: { return vec3(0.2, 0.8, 0.9); }
        case specialization::CLEARCOAT: { return vec3(0.1, 0.2, 0.9); }
        case specialization::DIFFUSE_TRANSMISSION: { return vec3(0.2, 0.8, 0.2); }
        case specialization::UNLIT: { return vec3(0.8, 0.1, 0.8); }
        default: { return vec3(specialization::unpack_reflectance(word) / 2.0); }
    }
}
#endif

#ifdef DEBUG_MOTION
fn motion_color(pixel: Pixel) -> vec3<f32> {
#ifdef GBUFFER_MOTION
    if (pixel.valid_mask & layout::MOTION_VALID) == 0u {
        return vec3(0.0);
    }
    let word = textureLoad(motion_texture, pixel.position, 0).r;
    return vec3(saturate(0.5 + 5.0 * motion::unpack_motion(word)), 0.5);
#else
    return vec3(0.0);
#endif
}
#endif

#ifdef DEBUG_VISIBILITY_MASK
fn visibility_mask_color(pixel: Pixel) -> vec3<f32> {
#ifdef GBUFFER_VISIBILITY_MASK
    if (pixel.valid_mask & layout::VISIBILITY_MASK_VALID) != 0u {
        let mask = textureLoad(visibility_mask_texture, pixel.position, 0).r;
        // Hashing gives neighbouring masks distant colours (Knuth 1973, "The Art of Computer Programming" 3, 6.4).
        return unpack4x8unorm(mask * 2654435769u).gba;
    }
#endif
    return vec3(0.5);
}
#endif

fn debug_color(pbr: PbrInput, pixel: Pixel) -> vec3<f32> {
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
    return world_geometric_normal(pixel.position, pixel.depth) * 0.5 + 0.5;
#else ifdef DEBUG_EMISSIVE
    return pbr.material.emissive.rgb;
#else ifdef DEBUG_SHADING_MODEL
    return shading_model_color(pixel.specialization_word);
#else ifdef DEBUG_MOTION
    return motion_color(pixel);
#else ifdef DEBUG_VISIBILITY_MASK
    return visibility_mask_color(pixel);
#else
    let z = (view.view_from_world * pbr.world_position).z;
    return vec3(1.0 / (1.0 + abs(z)));
#endif
}
