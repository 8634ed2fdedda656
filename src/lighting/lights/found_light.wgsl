// Indirect light that other effects have found for the pixel.
#define_import_path bevy_lean_deferred::lighting::lights::found_light

#import bevy_lean_deferred::gbuffer::layout::is_nan
#import bevy_pbr::mesh_view_bindings::view

#ifdef INDIRECT_SPECULAR
#import bevy_lean_deferred::lighting::bindings::indirect_specular_texture
#endif

#ifdef INDIRECT_DIFFUSE
#import bevy_lean_deferred::lighting::bindings::indirect_diffuse_texture
#endif

const LARGEST_HALF: f32 = 65504.0;

/// In cd/m², before exposure.
struct FoundLight {
    /// From about the mirrored direction.
    radiance: vec3<f32>,
    /// With which it takes the place of the environment, 0 to 1.
    confidence: f32,
    /// Mean radiance from other surfaces.
    irradiance: vec3<f32>,
    /// Of what the environment sends, 0 to 1.
    visibility: f32,
    /// What the material's own occlusion leaves of light from around.
    material_visibility: vec3<f32>,
}

fn found_light(pixel: vec2<i32>, material_visibility: vec3<f32>) -> FoundLight {
    var found: FoundLight;
    found.visibility = 1.0;
    found.material_visibility = material_visibility;
#ifdef INDIRECT_SPECULAR
    let specular_size = textureDimensions(indirect_specular_texture);
    let specular = finite(textureLoad(indirect_specular_texture, inside(pixel, specular_size), 0));
    found.radiance = specular.rgb / view.exposure;
    found.confidence = saturate(specular.a);
#endif
#ifdef INDIRECT_DIFFUSE
    let diffuse_size = textureDimensions(indirect_diffuse_texture);
    let diffuse = finite(textureLoad(indirect_diffuse_texture, inside(pixel, diffuse_size), 0));
    found.irradiance = diffuse.rgb / view.exposure;
    found.visibility = 1.0 - saturate(diffuse.a);
#endif
    return found;
}

/// The pixel itself, but where the texture is one of a single texel, or of another frame.
fn inside(pixel: vec2<i32>, size: vec2<u32>) -> vec2<i32> {
    return min(pixel, vec2<i32>(size) - 1);
}

/// `texel` with finite light; 0 where it has a NaN.
fn finite(texel: vec4<f32>) -> vec4<f32> {
    let number = select(texel, vec4(0.0), is_nan(texel.r + texel.g + texel.b + texel.a));
    return clamp(number, vec4(0.0), vec4(LARGEST_HALF));
}
