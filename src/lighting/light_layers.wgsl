// Masks lights, light probes and decals by the layers of each pixel's mesh. Bevy's iterator over decals is overridden to skip masked
// ones.
#define_import_path bevy_lean_deferred::lighting::light_layers

#ifdef FORWARD_MESH
#import bevy_lean_deferred::lighting::forward::bindings::light_layers
#else
#import bevy_lean_deferred::lighting::bindings::light_layers
#import bevy_lean_deferred::lighting::surface::Pixel
#endif
#import bevy_lean_deferred::lighting::parts

#ifdef GBUFFER_VISIBILITY_MASK
#import bevy_lean_deferred::gbuffer::layout::VISIBILITY_MASK_VALID
#import bevy_lean_deferred::lighting::bindings::visibility_mask_texture
#endif

#ifdef CLUSTERED_DECALS_ARE_USABLE
#import bevy_pbr::clustered_forward::get_clusterable_object_id
#import bevy_pbr::decal::clustered
#import bevy_pbr::decal::clustered::ClusteredDecalIterator
#endif

/// Layers of the mesh at this invocation's pixel: layer 0, unless a mesh wrote others.
var<private> mesh_layers: u32 = 1u;

#ifdef FORWARD_MESH
/// Sets the layers of the mesh that is drawn.
fn enter_mesh(layers: u32) {
    mesh_layers = layers;
}
#else
fn enter_pixel(pixel: Pixel) {
#ifdef GBUFFER_VISIBILITY_MASK
    if (pixel.valid_mask & VISIBILITY_MASK_VALID) != 0u {
        mesh_layers = textureLoad(visibility_mask_texture, pixel.position, 0).r;
    }
#endif
}
#endif  // FORWARD_MESH

fn affects_mesh(layers: u32) -> bool {
    return (layers & mesh_layers) != 0u || !parts::has(parts::LIGHT_LAYERS);
}

/// Masks of the clustered light (x) and of the decal (y) with this index.
fn clustered_layers(index: u32) -> vec2<u32> {
    if index >= light_layers.clustered_count {
        return vec2(0xffffffffu);
    }
    return light_layers.clustered[index];
}

fn clustered_light_affects_mesh(id: u32) -> bool {
    return affects_mesh(clustered_layers(id).x);
}

fn directional_light_affects_mesh(id: u32) -> bool {
    return affects_mesh(light_layers.directional_lights[id]);
}

fn rect_light_affects_mesh(id: u32) -> bool {
    return affects_mesh(light_layers.rect_lights[id]);
}

fn reflection_probe_affects_mesh(id: u32) -> bool {
    return affects_mesh(light_layers.reflection_probes[id]);
}

fn irradiance_volume_affects_mesh(id: u32) -> bool {
    return affects_mesh(light_layers.irradiance_volumes[id]);
}

#ifdef CLUSTERED_DECALS_ARE_USABLE
override fn clustered::clustered_decal_iterator_next(
    iterator: ptr<function, ClusteredDecalIterator>,
) -> bool {
    while clustered::clustered_decal_iterator_next(iterator) {
        let index = get_clusterable_object_id(u32((*iterator).decal_index_offset));
        if affects_mesh(clustered_layers(index).y) {
            return true;
        }
    }
    return false;
}
#endif
