// Light that leaves a surface towards the viewer, diffuse and specular apart.
#define_import_path bevy_lean_deferred::lighting::lights::lit

/// In cd/m², before exposure, without emitted light.
struct Lit {
    /// Light that has entered the surface: reflected diffusely, or transmitted.
    diffuse: vec3<f32>,
    /// Light reflected by the boundary, that of a clear coat included.
    specular: vec3<f32>,
}
