// Debug views that lighting draws: a channel of the G-buffer, a part of the light, or a colour for all that lighting draws.
#define_import_path bevy_lean_deferred::lighting::debug_view

#import bevy_lean_deferred::lighting::bindings::uniforms

#ifdef SHOWS_CHANNEL
#import bevy_lean_deferred::gbuffer::layout
#import bevy_lean_deferred::lighting::surface::Pixel
#endif

#ifdef DEBUG_ALBEDO
#ifdef GBUFFER_SPECIALIZATION
#import bevy_lean_deferred::lighting::surface::is_unlit
#import bevy_lean_deferred::shading_models::unlit::unpack_unlit
#endif
#endif

#ifdef DEBUG_GEOMETRIC_NORMAL
#import bevy_lean_deferred::lighting::surface::world_geometric_normal
#endif

#ifdef DEBUG_DEPTH
#import bevy_lean_deferred::lighting::surface::position_at
#endif

#ifdef DEBUG_EMISSIVE
#ifdef GBUFFER_EMISSIVE
#import bevy_lean_deferred::gbuffer::layout::light::unpack_light
#import bevy_lean_deferred::lighting::bindings::emissive_texture
#endif
#endif

#ifdef DEBUG_SHADING_MODEL
#import bevy_lean_deferred::gbuffer::layout::specialization
#endif

#ifdef DEBUG_MOTION
#ifdef GBUFFER_MOTION
#import bevy_lean_deferred::gbuffer::layout::motion
#import bevy_lean_deferred::lighting::bindings::motion_texture
#endif
#endif

#ifdef DEBUG_VISIBILITY_MASK
#ifdef GBUFFER_VISIBILITY_MASK
#import bevy_lean_deferred::lighting::bindings::visibility_mask_texture
#endif
#endif

#ifdef DEBUG_FORWARD
#import bevy_pbr::mesh_view_bindings::view
#endif

/// True if the debug view is shown at this pixel of the render target.
fn is_shown_at(pixel: vec2<i32>) -> bool {
    return u32(pixel.x) < uniforms.viewport_origin.x + uniforms.debug_columns;
}

#ifdef DEBUG_ALBEDO
fn albedo_color(pixel: Pixel) -> vec3<f32> {
#ifdef GBUFFER_SPECIALIZATION
    if is_unlit(pixel.specialization_word) {
        return unpack_unlit(pixel.specialization_word);
    }
#endif
    return layout::unpack_albedo(pixel.surface_word);
}
#endif

#ifdef DEBUG_EMISSIVE
fn emissive_color(pixel: Pixel) -> vec3<f32> {
#ifdef GBUFFER_EMISSIVE
    if (pixel.valid_mask & layout::EMISSIVE_VALID) != 0u {
        return unpack_light(textureLoad(emissive_texture, pixel.position, 0).r);
    }
#endif
    return vec3(0.0);
}
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
    if (pixel.valid_mask & layout::MOTION_VALID) != 0u {
        let word = textureLoad(motion_texture, pixel.position, 0).r;
        return vec3(saturate(0.5 + 5.0 * motion::unpack_motion(word)), 0.5);
    }
#endif
    return vec3(0.0);
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

#ifdef DEBUG_FORWARD
/// Magenta for lean surfaces, darker where they are turned away from the camera.
fn lean_color(pixel: Pixel) -> vec3<f32> {
    let normal = layout::unpack_normal(pixel.normal_word);
    let facing = normalize((view.view_from_world * vec4(normal, 0.0)).xyz).z;
    return vec3(0.5, 0.0, 0.5) * (0.2 + 0.8 * saturate(facing));
}
#endif

#ifdef SHOWS_CHANNEL
/// Colour of the channel.
fn channel_color(pixel: Pixel) -> vec3<f32> {
#ifdef DEBUG_ALBEDO
    return albedo_color(pixel);
#else ifdef DEBUG_METALLIC
    return vec3(layout::unpack_metallic(pixel.surface_word));
#else ifdef DEBUG_MATERIAL_OCCLUSION
    return vec3(layout::unpack_occlusion(pixel.surface_word));
#else ifdef DEBUG_NORMAL
    return layout::unpack_normal(pixel.normal_word) * 0.5 + 0.5;
#else ifdef DEBUG_ROUGHNESS
    return vec3(layout::unpack_roughness(pixel.normal_word));
#else ifdef DEBUG_GEOMETRIC_NORMAL
    return world_geometric_normal(pixel.position, pixel.depth) * 0.5 + 0.5;
#else ifdef DEBUG_DEPTH
    return vec3(1.0 / (1.0 + abs(position_at(pixel.position, pixel.depth).z)));
#else ifdef DEBUG_EMISSIVE
    return emissive_color(pixel);
#else ifdef DEBUG_SHADING_MODEL
    return shading_model_color(pixel.specialization_word);
#else ifdef DEBUG_MOTION
    return motion_color(pixel);
#else ifdef DEBUG_VISIBILITY_MASK
    return visibility_mask_color(pixel);
#else
    return lean_color(pixel);
#endif
}
#endif
