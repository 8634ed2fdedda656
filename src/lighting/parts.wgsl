// Parts of lighting that pipelines skip where a view does not need them.
#define_import_path bevy_lean_deferred::lighting::parts

#ifndef FORWARD_MESH
#import bevy_lean_deferred::lighting::bindings::uniforms
#endif

/// Bits of `LightingUniform::parts`.
const ENVIRONMENT_MAP: u32 = 0x1u;
const IRRADIANCE_VOLUME: u32 = 0x2u;
const SCREEN_SPACE_AMBIENT_OCCLUSION: u32 = 0x4u;
const CONTACT_SHADOWS: u32 = 0x8u;
const DISTANCE_FOG: u32 = 0x10u;
const ATMOSPHERE: u32 = 0x20u;
const SHADOW_MAPS: u32 = 0x40u;
const LIGHT_LAYERS: u32 = 0x80u;
const DIFFUSE_LIGHT: u32 = 0x100u;
const INDIRECT_SPECULAR: u32 = 0x200u;
const INDIRECT_DIFFUSE: u32 = 0x400u;
const AMBIENT_OCCLUSION: u32 = 0x800u;
const SCATTERS_LIGHT: u32 = 0x1000u;
const GAUSSIAN_SHADOWS: u32 = 0x2000u;
const TEMPORAL_SHADOWS: u32 = 0x4000u;
const OCCLUSION_WIDE: u32 = 0x8000u;
const OCCLUSION_EDGE_AWARE: u32 = 0x10000u;
const OCCLUSION_HALF: u32 = 0x20000u;
const OCCLUSION_MULTIBOUNCE: u32 = 0x40000u;
const OCCLUSION_OF_DIRECT_LIGHT: u32 = 0x80000u;

/// True if the view needs one of these parts, each of which the shader is compiled with. The same for all invocations.
fn has(parts: u32) -> bool {
#ifdef FORWARD_MESH
    // Compiled for the view.
    return true;
#else
    return (uniforms.parts & parts) != 0u;
#endif
}
