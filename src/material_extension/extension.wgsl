// Data of a `ShadingExtension` in its material's bind group.
#define_import_path bevy_lean_deferred::material_extension::extension

struct Extension {
    shading_model: u32,
    /// Packed as in the G-buffer.
    arguments: u32,
}

#ifdef BINDLESS
#import bevy_pbr::mesh_bindings::mesh

struct ExtensionIndices {
    extension: u32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<storage> indices: array<ExtensionIndices>;
@group(#{MATERIAL_BIND_GROUP}) @binding(101) var<storage> extensions: array<Extension>;
#else
@group(#{MATERIAL_BIND_GROUP}) @binding(50) var<uniform> extension: Extension;
#endif

/// Extension of a mesh instance's material.
fn extension_of(instance_index: u32) -> Extension {
#ifdef BINDLESS
    // Low 16 bits: the material's slot in its bind group.
    let slot = mesh[instance_index].material_and_lightmap_bind_group_slot & 0xffffu;
    return extensions[indices[slot].extension];
#else
    return extension;
#endif
}
