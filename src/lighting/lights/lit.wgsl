// Light that leaves a surface towards the viewer, diffuse and specular apart.
#define_import_path bevy_lean_deferred::lighting::lights::lit

/// In cd/m², before exposure. What a surface emits is in neither part.
struct Lit {
    /// What has entered the surface: reflected diffusely, or transmitted.
    diffuse: vec3<f32>,
    /// What its boundary reflects, that of a clear coat too.
    specular: vec3<f32>,
}
