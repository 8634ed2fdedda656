// The binding of the crate's own when it lights a mesh of Bevy's passes, beside those of Bevy.
#define_import_path bevy_lean_deferred::lighting::forward::bindings

#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::bindings::LightLayersTable

@group(4) @binding(0) var<storage> light_layers: LightLayersTable;
#endif
