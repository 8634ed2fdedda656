// Lights pixels of the packed G-buffer by a fragment shader, for benches: in place of the dispatch, with the same functions.
#import bevy_lean_deferred::gbuffer::layout::light::within_halves
#import bevy_lean_deferred::lighting::bindings::uniforms
#import bevy_lean_deferred::lighting::shade::shade
#import bevy_lean_deferred::lighting::surface::read_pixel

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let place = vec2<u32>(position.xy) - uniforms.viewport_origin;
    let pixel = read_pixel(place);
    if !pixel.has_geometry {
        discard;
    }
    // No lights are culled per tile, so neither tile nor subgroup matter.
    let shaded = shade(pixel, vec2(0u), 0u);
    return vec4(within_halves(shaded.color.rgb), shaded.color.a);
}
