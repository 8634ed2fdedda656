// Light from all rectangular lights, like Bevy's `rect_light`: linearly transformed cosines (Heitz et al. 2016, "Real-Time
// Polygonal-Light Shading with Linearly Transformed Cosines").
#define_import_path bevy_lean_deferred::lighting::lights::rect_light

#import bevy_lean_deferred::lighting::lights::lit::Lit
#import bevy_lean_deferred::lighting::lights::shading_point::ShadingPoint
#import bevy_pbr::lighting::{getRangeFalloff, ltc_integrate_quad}
#import bevy_pbr::mesh_view_bindings::{area_light_luts, area_light_luts_sampler, lights}

#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::light_layers::rect_light_affects_mesh
#endif

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#import bevy_lean_deferred::lighting::lights::shading_point::{back_position, transmits}
#endif

/// Table entry of a roughness and a view angle.
struct Lobe {
    /// Transform from the lobe to a cosine.
    inverse: mat3x3<f32>,
    /// Reflected share, as factors of the reflectance at normal incidence and of its complement.
    magnitude: vec2<f32>,
}

fn lobe(perceptual_roughness: f32, NdotV: f32) -> Lobe {
    let uv = vec2(perceptual_roughness, sqrt(1.0 - NdotV)) * (63.0 / 64.0) + 0.5 / 64.0;
    let m = textureSampleLevel(area_light_luts, area_light_luts_sampler, uv, 0, 0.0);
    let magnitude = textureSampleLevel(area_light_luts, area_light_luts_sampler, uv, 1, 0.0).xy;
    return Lobe(
        mat3x3(vec3(m.x, 0.0, m.y), vec3(0.0, 1.0, 0.0), vec3(m.z, 0.0, m.w)),
        magnitude,
    );
}

/// `V`, or another direction if it is `N`: `ltc_integrate_quad` normalises its part perpendicular to `N`. Seen from straight
/// above, all such directions give the same result.
fn beside(N: vec3<f32>, V: vec3<f32>) -> vec3<f32> {
    let across = V - N * dot(V, N);
    let other = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), abs(N.x) > 0.5);
    return select(V, other, dot(across, across) < 1e-12);
}

const COSINE: mat3x3<f32> = mat3x3(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);

fn corners_of(id: u32) -> array<vec3<f32>, 4> {
    let light = &lights.rect_lights[id];
    let right = (*light).right * (*light).width * 0.5;
    let up = (*light).up * (*light).height * 0.5;
    return array(
        (*light).position + right - up,
        (*light).position - right - up,
        (*light).position - right + up,
        (*light).position + right + up,
    );
}

/// Share of the light's colour that reaches `position`: 0 behind the light.
fn falloff_at(id: u32, position: vec3<f32>, corner: vec3<f32>) -> f32 {
    let light = &lights.rect_lights[id];
    if dot(cross((*light).up, (*light).right), position - corner) <= 0.0 {
        return 0.0;
    }
    let to_light = (*light).position - position;
    let range_square = max((*light).range * (*light).range, 0.0001);
    return getRangeFalloff(dot(to_light, to_light), 1.0 / range_square);
}

// The lobes of a surface.
const DIFFUSE: u32 = 0u;
const SPECULAR: u32 = 1u;
const COAT: u32 = 2u;
#ifdef STANDARD_MATERIAL_CLEARCOAT
const LOBES: u32 = 3u;
#else
const LOBES: u32 = 2u;
#endif

fn add_rect_lights(point: ptr<function, ShadingPoint>, lit: ptr<function, Lit>) {
    let count = lights.n_rect_lights;
    if count == 0u {
        return;
    }
    let N = (*point).N;
    let V = beside(N, (*point).V);
    let base = lobe((*point).perceptual_roughness, (*point).NdotV);
    // Factors of the light in each lobe.
    var diffuse = (*point).diffuse_color;
    var specular = (*point).F_normal * base.magnitude.x + (1.0 - (*point).F_normal) * base.magnitude.y;
#ifdef STANDARD_MATERIAL_CLEARCOAT
    var coat: Lobe;
    var reflected = 0.0;
    if (*point).clearcoat > 0.0 {
        coat = lobe((*point).clearcoat_perceptual_roughness, (*point).NdotV);
        let magnitude = 0.04 * coat.magnitude.x + 0.96 * coat.magnitude.y;
        let passed = 1.0 - (*point).clearcoat * magnitude;
        reflected = (*point).clearcoat * magnitude;
        diffuse *= passed;
        specular *= passed * passed;
    }
#endif
    // One loop over the lobes of all lights: the integral's code is long and takes many registers.
    for (var i = 0u; i < LOBES * count; i++) {
        let id = i / LOBES;
#ifdef LIGHT_LAYERS
        if !rect_light_affects_mesh(id) {
            continue;
        }
#endif
        let corners = corners_of(id);
        let color = lights.rect_lights[id].color.rgb;
        let number = i % LOBES;
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
        if number == DIFFUSE && transmits(point) {
            (*lit).diffuse += color * transmitted_rect_light(point, id, corners);
        }
#endif
        let falloff = falloff_at(id, (*point).position, corners[0]);
        if falloff == 0.0 {
            continue;
        }
        var inverse = COSINE;
        var factor = diffuse;
        if number == SPECULAR {
            inverse = base.inverse;
            factor = specular;
        }
#ifdef STANDARD_MATERIAL_CLEARCOAT
        if number == COAT {
            if reflected == 0.0 {
                continue;
            }
            inverse = coat.inverse;
            factor = vec3(reflected);
        }
#endif
        let integral = ltc_integrate_quad(N, V, (*point).position, inverse, corners);
        let light = factor * color * (falloff * integral);
        if number == DIFFUSE {
            (*lit).diffuse += light;
        } else {
            (*lit).specular += light;
        }
    }
}

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
/// Light transmitted from the back, per colour of the light. Bevy treats the back as a surface of roughness 1 without
/// reflectance, seen from straight behind, and adds its specular reflection.
fn transmitted_rect_light(
    point: ptr<function, ShadingPoint>,
    id: u32,
    corners: array<vec3<f32>, 4>,
) -> vec3<f32> {
    let position = back_position(point);
    let falloff = falloff_at(id, position, corners[0]);
    if falloff == 0.0 {
        return vec3(0.0);
    }
    let N = -(*point).N;
    let V = beside(N, -(*point).V);
    let back = lobe(1.0, 1.0);
    let diffuse = (*point).transmitted_color * ltc_integrate_quad(N, V, position, COSINE, corners);
    let specular = back.magnitude.y * ltc_integrate_quad(N, V, position, back.inverse, corners);
    return (diffuse + specular) * falloff;
}
#endif
