// Tiles and blocks of the picture whose light scatters, and the geometry of texels.
#define_import_path bevy_lean_deferred::effects::subsurface::texel

#import bevy_lean_deferred::lighting::subsurface_light::{BLOCK_LOG, COUNT, MASKS, tile_bit}
#import bevy_lean_deferred::effects::subsurface::bindings::{tiles, view}

/// Number of listed blocks, which the workgroups of a pass share.
fn count_of_blocks() -> u32 {
    return tiles[COUNT];
}

/// Listed block with this number, counted from the viewport's corner.
fn listed_block(number: u32) -> vec2<i32> {
    let block = tiles[MASKS + view.blocks.x * view.blocks.y + number];
    return vec2<i32>(vec2(block % view.blocks.x, block / view.blocks.x));
}

/// Mask of the block's tiles that have light.
fn mask_of(block: vec2<i32>) -> u32 {
    if any(block < vec2(0)) || any(block >= vec2<i32>(view.blocks)) {
        return 0u;
    }
    return tiles[MASKS + u32(block.y) * view.blocks.x + u32(block.x)];
}

/// True if the block has any light. In textures, other blocks hold light of earlier frames.
fn is_listed(block: vec2<i32>) -> bool {
    return mask_of(block) != 0u;
}

/// True if lighting wrote the light that enters at this pixel. Other tiles hold light of earlier frames.
fn is_written(pixel: vec2<i32>) -> bool {
    return (mask_of(pixel >> vec2(BLOCK_LOG)) & tile_bit(vec2<u32>(pixel))) != 0u;
}

/// Pixels per metre along the vertical axis, at a distance of `metres`.
fn pixels_per_metre_at(metres: f32) -> f32 {
    return abs(view.pixels_per_metre.y) / select(max(metres, 1e-6), 1.0, view.is_orthographic != 0u);
}

/// View-space direction from a pixel to the viewer.
fn to_viewer(pixel: vec2<f32>) -> vec3<f32> {
    if view.is_orthographic != 0u {
        return vec3(0.0, 0.0, 1.0);
    }
    return normalize(vec3((view.center - pixel) / view.pixels_per_metre, 1.0));
}
