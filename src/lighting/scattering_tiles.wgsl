// Writes the light that enters surfaces with subsurface scattering, and notes the tiles that have any.
#define_import_path bevy_lean_deferred::lighting::scattering_tiles

#ifdef SCATTERS_LIGHT
#import bevy_lean_deferred::gbuffer::layout::specialization
#import bevy_lean_deferred::lighting::bindings::{
    scattering_tiles, subsurface_light_texture, subsurface_picture_texture,
}
#import bevy_lean_deferred::lighting::shade::Shaded
#import bevy_lean_deferred::lighting::subsurface_light::{
    BLOCK_LOG, COUNT, Entry, MASKS, MATERIALS, MOST_MATERIALS, Receiver, pack_entry, pack_receiver, tile_bit,
}
#import bevy_lean_deferred::lighting::surface::{Pixel, position_at}
#import bevy_pbr::mesh_view_bindings::view

/// Largest `arguments + 1` of the tile's materials; 0 if no light scatters.
var<workgroup> light_scatters: atomic<u32>;
/// That value and the number of its material: for most tiles the only one.
var<workgroup> common_material: vec2<u32>;

/// Number of the material with these arguments in this frame, allocated on first use: the first free one from a hash of the
/// arguments on. Beyond `MOST_MATERIALS`, some materials share a number.
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
        // Another material has the number. 0: the weak exchange failed spuriously, so it is retried.
        if known != 0u {
            number = number % MOST_MATERIALS + 1u;
        }
    }
    return number;
}

/// Row-major index of the block.
fn block_of(corner: vec2<u32>, blocks: vec2<u32>) -> u32 {
    let block = corner >> vec2(BLOCK_LOG);
    return block.y * blocks.x + block.x;
}

/// Writes the light of the tile, sets its bit in its block's mask, and lists the block if the bit is its first. Must be called by
/// all invocations of a tile. Tiles without such light keep stale texels, which are not read.
fn write_entering_light(pixel: Pixel, shaded: Shaded, place: vec2<u32>, corner: vec2<u32>, invocation: u32) {
    let arguments = specialization::unpack_arguments(pixel.specialization_word);
    let scatters = pixel.has_geometry
        && specialization::unpack_shading_model(pixel.specialization_word) == specialization::SUBSURFACE;
    if invocation == 0u {
        atomicStore(&light_scatters, 0u);
    }
    workgroupBarrier();
    if scatters {
        atomicMax(&light_scatters, arguments + 1u);
    }
    workgroupBarrier();
    let blocks = textureDimensions(subsurface_light_texture) >> vec2(BLOCK_LOG);
    let block = block_of(corner, blocks);
    var noted = 1u;
    if invocation == 0u {
        let first = atomicLoad(&light_scatters);
        var number = 0u;
        if first != 0u {
            // The old mask is used last, which hides the latency of the atomic.
            noted = atomicOr(&scattering_tiles[MASKS + block], tile_bit(corner));
            number = number_of(first - 1u);
        }
        common_material = vec2(first, number);
    }
    let usual = workgroupUniformLoad(&common_material);
    if usual.x == 0u {
        return;
    }
    var entry = vec2(0u);
    if scatters {
        var material = usual.y;
        if usual.x != arguments + 1u {
            material = number_of(arguments);
        }
        // In metres, even if the camera is scaled.
        let metres = -position_at(pixel.position, pixel.depth).z * length(view.world_from_view[2].xyz);
        entry = pack_entry(Entry(metres, material, shaded.entering));
        let receiver = Receiver(shaded.color, shaded.leaving, pixel.normal_word);
        textureStore(subsurface_picture_texture, place, pack_receiver(receiver));
    }
    textureStore(subsurface_light_texture, place, vec4(entry, 0u, 0u));
    if noted == 0u {
        let number = atomicAdd(&scattering_tiles[COUNT], 1u);
        atomicStore(&scattering_tiles[MASKS + blocks.x * blocks.y + number], block);
    }
}
#endif
