// A texture that covers the viewport, in place of the picture.
#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput

#ifdef SHOWS_SPECULAR
#import bevy_lean_deferred::gbuffer::layout::indirect_specular::unpack_specular
#import bevy_render::view::View

@group(0) @binding(0) var found_texture: texture_2d<u32>;
@group(0) @binding(1) var<uniform> view: View;
#else ifdef SHOWS_HIT
@group(0) @binding(0) var found_texture: texture_2d<u32>;
#else
@group(0) @binding(0) var found_texture: texture_2d<f32>;
#endif

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) vec4<f32> {
#ifdef SHOWS_SPECULAR
    let size = view.main_pass_viewport.zw;
#else
    let size = vec2<f32>(textureDimensions(found_texture));
#endif
    let place = vec2<u32>(min(in.uv * size, size - 1.0));
#ifdef SHOWS_SPECULAR
    let texel = unpack_specular(found_texture, place);
#else
    let texel = textureLoad(found_texture, place, 0);
#endif
#ifdef SHOWS_SPECULAR_LIGHT
    let color = texel.rgb * texel.a;
#else ifdef SHOWS_SPECULAR_CONFIDENCE
    let color = vec3(texel.a);
#else ifdef SHOWS_BARE_LIGHT
    let color = texel.rgb;
#else ifdef SHOWS_ONE_MINUS_ALPHA
    let color = vec3(1.0 - texel.a);
#else
    // See `pack_hit` of reflections: metres, and eight bits of something else.
    let metres = bitcast<f32>(texel.r & 0xffffff00u);
    let color = vec3(select(1.0 / (1.0 + metres), 0.0, metres == 0.0));
#endif
    return vec4(color, 1.0);
}
