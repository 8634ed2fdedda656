// Shows a texture, in whose corner the viewport begins, in place of the picture.
#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import bevy_render::view::View

/// Pixels per side of a texel.
const DIVISOR: u32 = #{DIVISOR}u;

#ifdef SHOWS_HIT
@group(0) @binding(0) var source_texture: texture_2d<u32>;
#else
@group(0) @binding(0) var source_texture: texture_2d<f32>;
#endif
@group(0) @binding(1) var<uniform> view: View;

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(in.uv * view.main_pass_viewport.zw);
    let texel = textureLoad(source_texture, pixel / DIVISOR, 0);
#ifdef SHOWS_LIGHT
    let color = texel.rgb * texel.a;
#else ifdef SHOWS_BARE_LIGHT
    let color = texel.rgb;
#else ifdef SHOWS_ALPHA
    let color = vec3(texel.a);
#else ifdef SHOWS_ONE_MINUS_ALPHA
    // Negative alpha is -(number of a pixel + share).
    let color = vec3(1.0 - select(texel.a, fract(-texel.a), texel.a < 0.0));
#else
    // Packed by `pack_hit` of reflections: metres, and eight bits of other data.
    let metres = bitcast<f32>(texel.r & 0xffffff00u);
    let color = vec3(select(1.0 / (1.0 + metres), 0.0, metres == 0.0));
#endif
    return vec4(color, 1.0);
}
