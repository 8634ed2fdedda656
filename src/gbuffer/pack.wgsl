// From a material to the packed G-buffer, for the fragment shaders of materials.
#define_import_path bevy_lean_deferred::gbuffer::pack

#import bevy_lean_deferred::gbuffer::layout::{Surface, pack}
#import bevy_pbr::{
    pbr_functions::alpha_discard,
    pbr_types::PbrInput,
    prepass_io::VertexOutput,
}

#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither
#endif

/// The base targets of the G-buffer.
struct GBufferOutput {
    @location(0) surface: u32,
    @location(1) normal: u32,
}

/// Discards fragments that the alpha mask or a visibility range's crossfade leave out.
fn apply_discards(in: VertexOutput, pbr_input: ptr<function, PbrInput>) {
#ifdef VISIBILITY_RANGE_DITHER
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif
    (*pbr_input).material.base_color =
        alpha_discard((*pbr_input).material, (*pbr_input).material.base_color);
}

/// Packs what the base targets carry of `in`: base colour, metallic, roughness, shading normal and occlusion.
fn pack_pbr_input(in: PbrInput) -> GBufferOutput {
    let words = pack(Surface(
        in.material.base_color.rgb,
        in.material.metallic,
        // The occlusion texture has one channel; all three are equal here.
        in.diffuse_occlusion.r,
        in.N,
        in.material.perceptual_roughness,
    ));
    return GBufferOutput(words.x, words.y);
}
