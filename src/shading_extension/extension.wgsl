// What of a `ShadingExtension` its material's bind group holds.
#define_import_path bevy_lean_deferred::shading_extension::extension

struct Extension {
    shading_model: u32,
    /// As the G-buffer stores them.
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

/// The extension of the material of a mesh instance.
fn extension_of(instance_index: u32) -> Extension {
#ifdef BINDLESS
    // Low 16 bits: the material's place in its bind group.
    let slot = mesh[instance_index].material_and_lightmap_bind_group_slot & 0xffffu;
    return extensions[indices[slot].extension];
#else
    return extension;
#endif
}
