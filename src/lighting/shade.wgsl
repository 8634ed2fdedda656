// Shades a pixel: light of all kinds of sources and emission, seen through fog.
#define_import_path bevy_lean_deferred::lighting::shade

#import bevy_lean_deferred::gbuffer::layout::unpack_roughness
#import bevy_lean_deferred::lighting::parts
#import bevy_lean_deferred::lighting::surface::{Pixel, is_lit, pbr_input_from_gbuffer}
#import bevy_pbr::{
    clustered_forward::view_fragment_cluster_index,
    mesh_view_bindings::view,
    pbr_functions::main_pass_post_lighting_processing,
    pbr_types::PbrInput,
}

#import bevy_lean_deferred::lighting::lights::{
    brdf::{LightAccumulator, lit_of},
    directional_light::{DirectionalShadows, add_directional_lights},
    emission::emitted_light,
    screen_space_light::{ScreenSpaceLight, screen_space_light},
    indirect_light::{Surroundings, add_indirect_light, surroundings_of},
    lit::Lit,
    shading_point::{NO_CLUSTER, ShadingPoint, set_material, shading_point},
}

#ifdef DEBUG_VIEW
#import bevy_lean_deferred::lighting::debug_view::is_shown_at
#endif

#ifdef SHOWS_CHANNEL
#import bevy_lean_deferred::lighting::debug_view::channel_color
#endif

#ifdef DIRECTIONAL_SHADOW_MAPS
#import bevy_lean_deferred::lighting::lights::directional_light::find_directional_shadows
#import bevy_lean_deferred::lighting::surface::receives_shadows
#endif

#ifdef CLUSTERED_LIGHTS
#import bevy_lean_deferred::lighting::lights::clustered_lights::add_clustered_lights
#endif

#ifdef AREA_LIGHT_LUTS
#import bevy_lean_deferred::lighting::lights::rect_light::add_rect_lights
#endif

#ifdef SHADING_MODEL_RIM
#import bevy_lean_deferred::gbuffer::layout::specialization::unpack_arguments
#import bevy_lean_deferred::lighting::surface::has_lightmap
#import bevy_lean_deferred::shading_models::rim::{ambient_light_behind, rim_light}
#endif

#ifdef SCATTERS_LIGHT
#import bevy_lean_deferred::gbuffer::layout::specialization
#import bevy_lean_deferred::lighting::subsurface_light::LEAST_ALBEDO
#import bevy_lean_deferred::shading_models::subsurface::unpack_subsurface_colors_before
#endif

#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::light_layers
#endif

#ifdef CLUSTERED_DECALS_ARE_USABLE
#import bevy_lean_deferred::gbuffer::layout::light::{LARGEST_HALF, pack_halves, unpack_halves}
#import bevy_pbr::decal::clustered::apply_decals
#endif

#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
#import bevy_lean_deferred::lighting::visibility::apply_ssao
#endif

#ifdef INDIRECT_DIFFUSE
#import bevy_lean_deferred::lighting::visibility::apply_visibility
#endif

#ifdef LEAN_AMBIENT_OCCLUSION
#import bevy_lean_deferred::lighting::bindings::uniforms
#import bevy_lean_deferred::lighting::visibility::apply_occlusion
#endif

/// Result for a pixel.
struct Shaded {
    /// Exposed colour.
    color: vec4<f32>,
#ifdef DIFFUSE_LIGHT
    /// Part of `color` that leaves the surface in all directions alike, before fog.
    diffuse: vec3<f32>,
#endif
#ifdef SCATTERS_LIGHT
    /// Diffuse light that scatters beneath the surface, without emission and before fog. Also before the base colour, where that is
    /// applied after scattering.
    entering: vec3<f32>,
    /// Factor of scattered light: fog and, where it is applied after scattering, the base colour.
    leaving: vec3<f32>,
#endif
}

/// Outgoing light, or the part of it that is shown at `pixel`.
fn shown_light(pixel: Pixel, lit: Lit) -> vec3<f32> {
#ifdef SHOWS_PART_OF_LIGHT
    if is_shown_at(pixel.position) {
#ifdef DEBUG_DIFFUSE_LIGHT
        return lit.diffuse;
#else
        return lit.specular;
#endif
    }
#endif
    return lit.diffuse + lit.specular;
}

/// Adds `lit`, exposed and scaled by `direct_visibility`.
fn show(shaded: ptr<function, Shaded>, pixel: Pixel, lit: Lit, direct_visibility: f32) {
    let exposure = view.exposure * direct_visibility;
#ifdef DIFFUSE_LIGHT
    (*shaded).diffuse += exposure * lit.diffuse;
#endif
#ifdef SCATTERS_LIGHT
    (*shaded).entering += exposure * lit.diffuse;
#endif
    (*shaded).color += vec4(exposure * shown_light(pixel, lit), 0.0);
}

#ifdef CLUSTERED_DECALS_ARE_USABLE
/// Packs what decals change besides the normal: colour and metallic, emission and roughness, in half floats.
fn pack_decaled(pbr: PbrInput) -> vec4<u32> {
    let color = vec4(pbr.material.base_color.rgb, pbr.material.metallic);
    let light = vec4(pbr.material.emissive.rgb, pbr.material.perceptual_roughness);
    return vec4(pack_halves(min(color, vec4(LARGEST_HALF))), pack_halves(min(light, vec4(LARGEST_HALF))));
}

/// Sets what `pack_decaled` packed.
fn unpack_decaled(words: vec4<u32>, pbr: ptr<function, PbrInput>) {
    let color = unpack_halves(words.xy);
    let light = unpack_halves(words.zw);
    (*pbr).material.base_color = vec4(color.rgb, 1.0);
    (*pbr).material.metallic = color.a;
    (*pbr).material.emissive = vec4(light.rgb, 0.0);
    (*pbr).material.perceptual_roughness = light.a;
}
#endif

/// Shades a pixel. Lights are culled per tile: must be called by all invocations of a tile, also by those whose pixel has no
/// geometry. `corner` is the tile's first pixel. `member` is the invocation's index in the subgroup, or else in the workgroup.
fn shade(pixel: Pixel, corner: vec2<u32>, member: u32) -> Shaded {
    var pbr: PbrInput;
    var point: ShadingPoint;
    var cluster = NO_CLUSTER;
    var shaded: Shaded;
    var accumulator: LightAccumulator;
#ifdef CLUSTERED_DECALS_ARE_USABLE
    var decaled: vec4<u32>;
#endif
    if pixel.has_geometry {
        var shadows: DirectionalShadows;
#ifdef LIGHT_LAYERS
        light_layers::enter_pixel(pixel);
#endif
#ifdef DIRECTIONAL_SHADOW_MAPS
        if receives_shadows(pixel) {
            find_directional_shadows(pixel, &shadows);
        }
#endif
        pbr = pbr_input_from_gbuffer(pixel);
#ifdef CLUSTERED_DECALS_ARE_USABLE
        apply_decals(&pbr);
        decaled = pack_decaled(pbr);
#endif
        if is_lit(pixel) {
            let view_z = (view.view_from_world * pbr.world_position).z;
            cluster = view_fragment_cluster_index(pbr.frag_coord.xy, view_z, pbr.is_orthographic);
            point = shading_point(pbr, pixel, view_z);
            add_directional_lights(&point, &shadows, &accumulator);
        }
    }
#ifdef CLUSTERED_LIGHTS
    add_clustered_lights(&point, corner, cluster, member, &accumulator);
#endif
    if !pixel.has_geometry {
        return shaded;
    }
    // Before terms of the surface are live: interpolation and light probes take many registers.
    var found: ScreenSpaceLight;
    var around: Surroundings;
    if is_lit(pixel) {
#ifdef CLUSTERED_DECALS_ARE_USABLE
        point.perceptual_roughness = unpack_halves(decaled.zw).a;
#else
        point.perceptual_roughness = unpack_roughness(pixel.normal_word);
#endif
        around = surroundings_of(&point, cluster);
        found = screen_space_light(pixel);
    }
    // Unpacked again, so that fewer registers are live in the loops over lights.
    pbr = pbr_input_from_gbuffer(pixel);
#ifdef CLUSTERED_DECALS_ARE_USABLE
    unpack_decaled(decaled, &pbr);
    pbr.N = point.N;
#endif
    if is_lit(pixel) {
        set_material(&point, pbr.material);
        let direct = lit_of(&point, accumulator);
        // Share of direct light that occlusion leaves.
        var direct_visibility = 1.0;
        found.material_visibility = pbr.diffuse_occlusion;
#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
        if parts::has(parts::SCREEN_SPACE_AMBIENT_OCCLUSION) {
            apply_ssao(&pbr, pixel.position);
        }
#endif
#ifdef LEAN_AMBIENT_OCCLUSION
        if parts::has(parts::AMBIENT_OCCLUSION) {
            let visibility = apply_occlusion(&pbr, pixel.position, pixel.depth);
#ifdef OCCLUSION_OF_DIRECT_LIGHT
            if parts::has(parts::OCCLUSION_OF_DIRECT_LIGHT) {
                direct_visibility = 1.0 - uniforms.occlusion_of_direct_light * (1.0 - visibility);
            }
#endif
        }
#endif
#ifdef INDIRECT_DIFFUSE
        if parts::has(parts::INDIRECT_DIFFUSE) {
            apply_visibility(&pbr, found.visibility, vec3(found.visibility));
        }
#endif
        var lit: Lit;
        emit(&shaded, pixel, emission(&point, pbr, pixel, around));
        add_indirect_light(&point, pbr, around, found, &lit);
        show(&shaded, pixel, lit, 1.0);
#ifdef AREA_LIGHT_LUTS
        lit = Lit();
        add_rect_lights(&point, &lit);
        show(&shaded, pixel, lit, direct_visibility);
#endif
        show(&shaded, pixel, direct, direct_visibility);
    } else {
        emit(&shaded, pixel, pbr.material.base_color.rgb);
    }
#ifdef SCATTERS_LIGHT
    apply_fog_and_base_color(pbr, pixel, &shaded);
#else
    if !shows_debug_view(pixel) {
        shaded.color = behind_fog(pbr, shaded.color);
    }
#endif
#ifdef SHOWS_CHANNEL
    // Light is computed all the same: effects of the next frame read it.
    if shows_debug_view(pixel) {
        shaded.color = vec4(channel_color(pixel), 1.0);
    }
#endif
    return shaded;
}

/// `color` as seen through fog.
fn behind_fog(pbr: PbrInput, color: vec4<f32>) -> vec4<f32> {
    if !parts::has(parts::DISTANCE_FOG) {
        return color;
    }
    return main_pass_post_lighting_processing(pbr, color);
}

/// True where a debug view is shown, in front of which there is no fog.
fn shows_debug_view(pixel: Pixel) -> bool {
#ifdef DEBUG_VIEW
    return is_shown_at(pixel.position);
#else
    return false;
#endif
}

#ifdef SCATTERS_LIGHT
/// Applies fog to the pixel's colour. Where light scatters beneath the surface, also finds the factor of light that leaves it, and
/// divides light that enters it by the base colour if that is applied after scattering.
fn apply_fog_and_base_color(pbr: PbrInput, pixel: Pixel, shaded: ptr<function, Shaded>) {
    let scatters = specialization::unpack_shading_model(pixel.specialization_word) == specialization::SUBSURFACE;
    var leaving = vec3(1.0);
    if !shows_debug_view(pixel) {
        // Fog before white less fog before black, by one call: its code is long.
        var of_fog = vec3(0.0);
        let last = select(0u, 2u, scatters);
        for (var i = 0u; i <= last; i++) {
            var light = (*shaded).color;
            if i < last {
                light = vec4(vec3(f32(i)), 1.0);
            }
            let seen = behind_fog(pbr, light);
            if i == last {
                (*shaded).color = seen;
            } else if i == 1u {
                leaving = saturate(seen.rgb - of_fog);
            } else {
                of_fog = seen.rgb;
            }
        }
    } else {
#ifndef DEBUG_DIFFUSE_LIGHT
        leaving = vec3(0.0);
#endif
    }
    if !scatters {
        return;
    }
    (*shaded).leaving = leaving;
    let arguments = specialization::unpack_arguments(pixel.specialization_word);
    if !unpack_subsurface_colors_before(arguments) {
        let albedo = max(pbr.material.base_color.rgb, vec3(LEAST_ALBEDO));
        (*shaded).entering /= albedo;
        (*shaded).leaving *= albedo;
    }
}
#endif

/// Starts an opaque pixel with emitted `light`, or black where only part of the light is shown.
fn emit(shaded: ptr<function, Shaded>, pixel: Pixel, light: vec3<f32>) {
#ifdef DIFFUSE_LIGHT
    (*shaded).diffuse = light;
#endif
    (*shaded).color = vec4(light, 1.0);
#ifdef SHOWS_PART_OF_LIGHT
    if is_shown_at(pixel.position) {
        (*shaded).color = vec4(0.0, 0.0, 0.0, 1.0);
    }
#endif
}

/// Emission and rim light, exposed.
fn emission(point: ptr<function, ShadingPoint>, pbr: PbrInput, pixel: Pixel, around: Surroundings) -> vec3<f32> {
    var light = emitted_light(pbr);
#ifdef SHADING_MODEL_RIM
    if (*point).has_rim_light {
        let arguments = unpack_arguments(pixel.specialization_word);
        light += rim_light(pbr, arguments, ambient_light_behind(has_lightmap(pixel)) + around.of_model);
    }
#endif
    return light;
}
