// Indirect light that other effects computed for the pixel.
#define_import_path bevy_lean_deferred::lighting::lights::screen_space_light

#ifndef FORWARD_MESH
#import bevy_lean_deferred::gbuffer::layout::is_nan
#import bevy_lean_deferred::gbuffer::layout::light::LARGEST_HALF
#import bevy_lean_deferred::lighting::bindings::uniforms
#import bevy_lean_deferred::lighting::parts
#import bevy_lean_deferred::lighting::surface::Pixel
#import bevy_pbr::mesh_view_bindings::view
#ifdef INDIRECT_SPECULAR
#import bevy_lean_deferred::lighting::bindings::indirect_specular_texture
#endif
#endif

#ifdef INDIRECT_DIFFUSE
#import bevy_lean_deferred::lighting::bindings::indirect_diffuse_texture
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::tiles::pixel_of_square
#import bevy_pbr::mesh_view_bindings::depth_prepass_texture as depth_texture
#endif

/// Light in cd/m², before exposure.
struct ScreenSpaceLight {
    /// Radiance from about the mirrored direction.
    radiance: vec3<f32>,
    /// Weight with which `radiance` replaces the environment, 0 to 1.
    confidence: f32,
    /// Mean radiance from other surfaces.
    irradiance: vec3<f32>,
    /// Visible share of the environment, 0 to 1.
    visibility: f32,
    /// Share of indirect light that the material's own occlusion leaves.
    material_visibility: vec3<f32>,
}

/// No light of other effects, and nothing that they hide.
fn no_screen_space_light(material_visibility: vec3<f32>) -> ScreenSpaceLight {
    var found: ScreenSpaceLight;
    found.visibility = 1.0;
    found.material_visibility = material_visibility;
    return found;
}

#ifndef FORWARD_MESH
/// Without the material's own occlusion.
fn screen_space_light(pixel: Pixel) -> ScreenSpaceLight {
    var found = no_screen_space_light(vec3(1.0));
#ifdef INDIRECT_LIGHT
    let place = pixel.position - vec2<i32>(uniforms.viewport_origin);
#endif
#ifdef INDIRECT_SPECULAR
    if parts::has(parts::INDIRECT_SPECULAR) {
        let specular = finite(textureLoad(indirect_specular_texture, inside(place, indirect_specular_texture), 0));
        found.radiance = specular.rgb / view.exposure;
        found.confidence = saturate(specular.a);
    }
#endif
#ifdef INDIRECT_DIFFUSE
    if parts::has(parts::INDIRECT_DIFFUSE) {
        let diffuse = indirect_diffuse(place, pixel.depth);
        found.irradiance = diffuse.rgb / view.exposure;
        found.visibility = 1.0 - saturate(diffuse.a);
    }
#endif
    return found;
}

/// `place`, clamped to the texture, which may have a single texel.
fn inside(place: vec2<i32>, texture: texture_2d<f32>) -> vec2<i32> {
    return clamp(place, vec2(0), vec2<i32>(textureDimensions(texture)) - 1);
}

/// `texel` clamped to finite light; 0 where it has a NaN.
fn finite(texel: vec4<f32>) -> vec4<f32> {
    let number = select(texel, vec4(0.0), is_nan(texel.r + texel.g + texel.b + texel.a));
    return clamp(number, vec4(0.0), vec4(LARGEST_HALF));
}
#endif  // FORWARD_MESH

#ifdef INDIRECT_DIFFUSE
fn indirect_diffuse(place: vec2<i32>, depth: f32) -> vec4<f32> {
    if uniforms.diffuse_is_half == 0u {
        return finite(textureLoad(indirect_diffuse_texture, inside(place, indirect_diffuse_texture), 0));
    }
    return scaled_up(place, depth);
}

/// Depth at a pixel, clamped to the viewport.
fn depth_in_view(place: vec2<i32>) -> f32 {
    let nearest = clamp(place, vec2(0), vec2<i32>(uniforms.viewport_size) - 1);
    return textureLoad(depth_texture, vec2<i32>(uniforms.viewport_origin) + nearest, 0);
}

/// Surface at a pixel.
struct Receiver {
    place: vec2<i32>,
    depth: f32,
    /// Change of depth per pixel.
    slope: vec2<f32>,
    /// 1 / the difference in depth up to which another pixel is of the same surface.
    inverse_step: f32,
}

/// Sum over the four texels around a pixel.
struct SumOfTexels {
    /// Light times weight.
    light: vec4<f32>,
    weights: f32,
}

/// Texel `i` of the four around the pixel at `place`, clamped to the view: the texture may be larger.
fn texel_around(place: vec2<i32>, i: i32) -> vec2<i32> {
    // A texel's centre is the middle of its 2×2 pixels. `first` is the last centre before the pixel.
    let first = (place + 1) / 2 - 1;
    let last = (vec2<i32>(uniforms.viewport_size) + 1) / 2 - 1;
    return clamp(first + vec2(i & 1, i >> 1u), vec2(0), last);
}

/// Adds the light of texel `i` of the four around a pixel. The texel shows the pixel `shown`.
fn add_texel(sum: ptr<function, SumOfTexels>, receiver: Receiver, i: i32, shown: vec2<i32>, light: vec4<f32>) {
    let is_near = (receiver.place & vec2(1)) == vec2(0);
    let near = select(vec2(0.25), vec2(0.75), (vec2(i & 1, i >> 1u) == vec2(1)) == is_near);
    let depth = depth_in_view(shown);
    let off = depth - receiver.depth - dot(receiver.slope, vec2<f32>(shown - receiver.place));
    let alike = select(saturate(2.0 - abs(off) * receiver.inverse_step), 0.0, depth == 0.0);
    // The least weight keeps the sum valid where no texel matches.
    let weight = near.x * near.y * alike + 1e-4;
    (*sum).light += weight * finite(light);
    (*sum).weights += weight;
}

/// Interpolates the four texels around the pixel, without those that show another surface. A texel shows the first of its 2×2 pixels. If
/// it shows another, its alpha is negative: the number of the pixel, plus the share of the hemisphere.
fn scaled_up(place: vec2<i32>, depth: f32) -> vec4<f32> {
    let slope = vec2(
        flatter_slope(depth_in_view(place - vec2(1, 0)), depth, depth_in_view(place + vec2(1, 0))),
        flatter_slope(depth_in_view(place - vec2(0, 1)), depth, depth_in_view(place + vec2(0, 1))),
    );
    let inverse_step = 1.0 / max(2.0 * (uniforms.edge.x * depth + uniforms.edge.y), 1e-30);
    let receiver = Receiver(place, depth, slope, inverse_step);
    var sum: SumOfTexels;
    var least_alpha = 0.0;
    for (var i = 0; i < 4; i++) {
        let texel = texel_around(place, i);
        let light = textureLoad(indirect_diffuse_texture, texel, 0);
        add_texel(&sum, receiver, i, 2 * texel, light);
        least_alpha = min(least_alpha, light.a);
    }
    if least_alpha < 0.0 {
        // In a second loop, because these depths depend on alpha: those above do not wait for it.
        sum = SumOfTexels();
        for (var i = 0; i < 4; i++) {
            let texel = texel_around(place, i);
            let light = textureLoad(indirect_diffuse_texture, texel, 0);
            let number = u32(max(-light.a, 0.0));
            let shown = 2 * texel + pixel_of_square(number & 3u);
            add_texel(&sum, receiver, i, shown, vec4(light.rgb, abs(light.a) - f32(number)));
        }
    }
    return sum.light / sum.weights;
}
#endif
