// Writes the light that enters surfaces beneath which it scatters, and lists the tiles that have some.
#define_import_path bevy_lean_deferred::lighting::scattering_tiles

#ifdef SCATTERS_LIGHT
#import bevy_lean_deferred::gbuffer::layout::specialization
#import bevy_lean_deferred::lighting::bindings::{
    scattering_tiles, subsurface_light_texture, subsurface_picture_texture, uniforms,
}
#import bevy_lean_deferred::lighting::shade::Shaded
#import bevy_lean_deferred::lighting::subsurface_light::{
    COUNT, Entry, MATERIALS, MOST_MATERIALS, Receiver, TILES, pack_entry, pack_receiver,
}
#import bevy_lean_deferred::lighting::surface::{Pixel, position_at}

/// The arguments of a material of the tile and 1, the largest; 0: no light scatters.
var<workgroup> light_scatters: atomic<u32>;
var<workgroup> light_is_written: u32;
/// Those arguments and 1, and the material's number: for most tiles the only one.
var<workgroup> common_material: vec2<u32>;

/// The number of the material with these arguments of the shading model, in this frame: the first free one from some place on.
/// Beyond the most materials some share theirs.
fn number_of(arguments: u32) -> u32 {
    var number = arguments % MOST_MATERIALS + 1u;
    for (var tries = 0u; tries < 2u * MOST_MATERIALS; tries++) {
        let place = &scattering_tiles[MATERIALS + number];
        var known = atomicLoad(place);
        if known == 0u {
            let exchange = atomicCompareExchangeWeak(place, 0u, arguments + 1u);
            known = select(exchange.old_value, arguments + 1u, exchange.exchanged);
        }
        if known == arguments + 1u {
            break;
        }
        // Else another one was faster; or nobody was, and it is tried again.
        if known != 0u {
            number = number % MOST_MATERIALS + 1u;
        }
    }
    return number;
}

/// To be called by all invocations of a tile. Tiles that had such light and have none any more are listed once more, without.
fn write_entering_light(pixel: Pixel, shaded: Shaded, place: vec2<u32>, corner: vec2<u32>, invocation: u32) {
    let word = pixel.specialization_word;
    let arguments = specialization::unpack_arguments(word);
    let scatters = pixel.has_geometry && specialization::unpack_shading_model(word) == specialization::SUBSURFACE;
    if invocation == 0u {
        atomicStore(&light_scatters, 0u);
    }
    workgroupBarrier();
    if scatters {
        atomicMax(&light_scatters, arguments + 1u);
    }
    workgroupBarrier();
    if invocation == 0u {
        let first = atomicLoad(&light_scatters);
        let has_light = u32(first != 0u);
        if has_light != 0u {
            common_material = vec2(first, number_of(first - 1u));
        }
        let tiles_in_row = (uniforms.viewport_size.x + 7u) / 8u;
        let capacity = (arrayLength(&scattering_tiles) - TILES) / 2u;
        let tile = corner.y / 8u * tiles_in_row + corner.x / 8u;
        let had_light = &scattering_tiles[TILES + capacity + tile];
        light_is_written = has_light | atomicLoad(had_light);
        if light_is_written != 0u {
            let index = atomicAdd(&scattering_tiles[COUNT], 1u);
            atomicStore(&scattering_tiles[TILES + index], corner.x | (corner.y << 16u));
            atomicStore(had_light, has_light);
        }
    }
    if workgroupUniformLoad(&light_is_written) == 0u {
        return;
    }
    var entry = vec2(0u);
    if scatters {
        var material = common_material.y;
        if common_material.x != arguments + 1u {
            material = number_of(arguments);
        }
        let metres = -position_at(pixel.position, pixel.depth).z;
        entry = pack_entry(Entry(metres, material, shaded.entering));
        let receiver = Receiver(shaded.color, shaded.leaving, arguments);
        textureStore(subsurface_picture_texture, place, pack_receiver(receiver));
    }
    textureStore(subsurface_light_texture, place, vec4(entry, 0u, 0u));
}
#endif
