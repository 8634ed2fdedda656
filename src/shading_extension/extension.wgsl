// What of a `ShadingExtension` its material's bind group holds.
#define_import_path bevy_lean_deferred::shading_extension::extension

struct Extension {
    shading_model: u32,
    /// As the G-buffer stores them.
    arguments: u32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> extension: Extension;
