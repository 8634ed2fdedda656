// Lights every pixel of the packed G-buffer.
//
// A view with special surfaces is lit by two dispatches of this shader. The first visits all tiles, lights those with plain
// surfaces only, and lists the others. The second (VISITED_VARIANTS) visits that list; it is compiled for the kinds of
// special surfaces in the view.
#import bevy_lean_deferred::gbuffer::layout::light::within_halves
#import bevy_lean_deferred::lighting::bindings::{output_texture, uniforms}
#import bevy_lean_deferred::lighting::parts
#import bevy_lean_deferred::lighting::shade::shade
#import bevy_lean_deferred::lighting::surface::{Pixel, read_pixel}
#import bevy_lean_deferred::tiles::{pixel_in_view, place_in_tile}

#ifdef LISTED_VARIANTS
#import bevy_lean_deferred::lighting::tile_list::{list_tile, variant_of}
#endif

#ifdef VISITED_VARIANTS
#import bevy_lean_deferred::lighting::tile_list::listed_tile
#endif

#ifdef SCATTERS_LIGHT
#import bevy_lean_deferred::lighting::scattering_tiles::write_entering_light
#endif

#ifdef DIFFUSE_LIGHT
#import bevy_lean_deferred::gbuffer::layout::light::pack_light
#import bevy_lean_deferred::lighting::bindings::diffuse_light_texture
#endif

#ifdef VISITED_VARIANTS
@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
#ifdef LIGHT_CULLING_BY_SUBGROUPS
    @builtin(subgroup_invocation_id) member: u32,
#endif
) {
    let tile = listed_tile(workgroup.xy);
    if !tile.is_listed {
        return;
    }
#ifndef LIGHT_CULLING_BY_SUBGROUPS
    let member = invocation;
#endif
    let place = tile.origin + place_in_tile(invocation);
    let pixel = read_pixel(place);
    light_tile(pixel, place, tile.origin, invocation, member);
}
#else   // VISITED_VARIANTS
@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
#ifdef LIGHT_CULLING_BY_SUBGROUPS
    @builtin(subgroup_invocation_id) member: u32,
#endif
) {
#ifndef LIGHT_CULLING_BY_SUBGROUPS
    let member = invocation;
#endif
    let place = pixel_in_view(tile.xy, invocation);
    let corner = place - place_in_tile(invocation);
    let pixel = read_pixel(place);
#ifdef LISTED_VARIANTS
    let variant = select(0u, variant_of(pixel.specialization_word), pixel.has_geometry);
    if list_tile(corner, variant, invocation) {
        return;
    }
#endif
    light_tile(pixel, place, corner, invocation, member);
}
#endif  // VISITED_VARIANTS

/// Shades and writes the pixel at `place`.
fn light_tile(pixel: Pixel, place: vec2<u32>, corner: vec2<u32>, invocation: u32, member: u32) {
    var shaded = shade(pixel, uniforms.viewport_origin + corner, member);
    shaded.color = vec4(within_halves(shaded.color.rgb), shaded.color.a);
#ifdef SCATTERS_LIGHT
    if parts::has(parts::SCATTERS_LIGHT) {
        write_entering_light(pixel, shaded, place, corner, invocation);
    }
#endif
    if pixel.has_geometry {
        textureStore(output_texture, pixel.position, shaded.color);
#ifdef DIFFUSE_LIGHT
        if parts::has(parts::DIFFUSE_LIGHT) {
            textureStore(diffuse_light_texture, place, vec4(pack_light(shaded.diffuse)));
        }
#endif
    } else {
        write_background(place);
    }
}

/// Writes a pixel without geometry.
fn write_background(place: vec2<u32>) {
    if any(place >= uniforms.viewport_size) {
        return;
    }
#ifdef DIFFUSE_LIGHT
    if parts::has(parts::DIFFUSE_LIGHT) {
        textureStore(diffuse_light_texture, place, vec4(0u));
    }
#endif
    if uniforms.writes_background != 0u {
        let position = vec2<i32>(uniforms.viewport_origin + place);
        textureStore(output_texture, position, uniforms.background);
    }
}
