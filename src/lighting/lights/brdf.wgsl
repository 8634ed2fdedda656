// Reflection of light from one direction: Bevy's `lighting` for one light, with shared terms computed once, and without the
// surface's colours, which are applied at the end. Bevy cites the source of each term, at `D_GGX` and others.
#define_import_path bevy_lean_deferred::lighting::lights::brdf

#import bevy_lean_deferred::lighting::lights::lit::Lit
#import bevy_lean_deferred::lighting::lights::shading_point::{ShadingPoint, fifth_power, smith, view_cosine, view_fresnel}

#ifdef SPHERE_LIGHTS
#import bevy_pbr::lighting::specular_fix_remap
#endif

#ifdef STANDARD_MATERIAL_ANISOTROPY
#import bevy_lean_deferred::lighting::lights::shading_point::bitangent_at
#import bevy_pbr::lighting::{D_GGX_anisotropic, V_GGX_anisotropic}
#endif

const INVERSE_PI: f32 = 0.31830987;

/// Response of the surface to one light: factors of the light's colour, each including N·L.
struct Response {
    /// Diffuse reflection, times π.
    diffuse: f32,
    /// Specular reflection at a reflectance of 1.
    specular: f32,
    /// `specular` times `(1 - L·H)⁵`, for the Fresnel term.
    fresnel: f32,
#ifdef STANDARD_MATERIAL_CLEARCOAT
    coat: f32,
#endif
}

/// Sum of the responses to all lights, times their colours.
struct LightAccumulator {
    diffuse: vec3<f32>,
    specular: vec3<f32>,
    fresnel: vec3<f32>,
    // Light of the shading model, of which a surface has one: reflected by the coat; or from behind, times π.
#ifdef STANDARD_MATERIAL_CLEARCOAT
    of_model: vec3<f32>,
#else ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    of_model: vec3<f32>,
#endif
}

fn accumulate(accumulator: ptr<function, LightAccumulator>, response: Response, color: vec3<f32>) {
    (*accumulator).diffuse += response.diffuse * color;
    (*accumulator).specular += response.specular * color;
    (*accumulator).fresnel += response.fresnel * color;
#ifdef STANDARD_MATERIAL_CLEARCOAT
    (*accumulator).of_model += response.coat * color;
#endif
}

/// Clamp of accumulated light: infinity × 0 is NaN.
const BRIGHTEST: f32 = 1e30;

/// Applies the surface's colours to the accumulated light.
fn lit_of(point: ptr<function, ShadingPoint>, accumulator: LightAccumulator) -> Lit {
    let normal = (*point).F_normal;
    let specular = min(accumulator.specular, vec3(BRIGHTEST));
    let fresnel = min(accumulator.fresnel, vec3(BRIGHTEST));
    // (1 - cos)⁵ interpolates from the reflectance at normal incidence to that at grazing angles (Schlick 1994).
    let boundary = normal * specular + ((*point).F_grazing - normal) * fresnel;
    var lit: Lit;
    lit.diffuse = (*point).diffuse_color * min(accumulator.diffuse, vec3(BRIGHTEST)) * INVERSE_PI;
    lit.specular = (*point).multiscatter * boundary;
#ifdef STANDARD_MATERIAL_CLEARCOAT
    lit.specular += select(vec3(0.0), min(accumulator.of_model, vec3(BRIGHTEST)), (*point).clearcoat > 0.0);
#endif
#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
    lit.diffuse += (*point).transmitted_color * min(accumulator.of_model, vec3(BRIGHTEST)) * INVERSE_PI;
#endif
    return lit;
}

/// Half vector of light and view, and the cosines.
struct Halfway {
    H: vec3<f32>,
    /// 0 to 1, like the other cosines.
    NdotL: f32,
    NdotH: f32,
    LdotH: f32,
}

/// Least squared length to divide by: normalising the zero vector would give NaN. Far below the rounding errors of sums of unit vectors.
const LEAST_SQUARE: f32 = 1e-20;

/// Normalises `v`; the zero vector stays as it is.
fn unit(v: vec3<f32>) -> vec3<f32> {
    return v * inverseSqrt(max(dot(v, v), LEAST_SQUARE));
}

fn halfway(point: ptr<function, ShadingPoint>, L: vec3<f32>) -> Halfway {
    let H = unit(L + (*point).V);
    let N = (*point).N;
    return Halfway(H, saturate(dot(N, L)), saturate(dot(N, H)), saturate(dot(L, H)));
}

/// Like `halfway`, for `L` of unit length: all cosines follow from those between normal, light and view.
fn halfway_to(point: ptr<function, ShadingPoint>, L: vec3<f32>) -> Halfway {
    let NdotL = dot((*point).N, L);
    // |L + V|². Rounding makes it negative where the light is opposite to the viewer.
    let square = max(2.0 + 2.0 * dot(L, (*point).V), 1e-7);
    let inverse = inverseSqrt(square);
    var h: Halfway;
#ifdef STANDARD_MATERIAL_ANISOTROPY
    h.H = (L + (*point).V) * inverse;
#endif
    h.NdotL = saturate(NdotL);
    h.NdotH = saturate((NdotL + (*point).signed_NdotV) * inverse);
    h.LdotH = saturate(0.5 * square * inverse);
    return h;
}

/// Distribution of microfacets, 1/sr (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces").
fn distribution(roughness: f32, NdotH: f32) -> f32 {
    let a = NdotH * roughness;
    let k = roughness / (1.0 - NdotH * NdotH + a * a);
    return k * k * INVERSE_PI;
}

/// Diffuse reflection times π and N·L (Burley 2012, "Physically-Based Shading at Disney").
fn diffuse_reflection(point: ptr<function, ShadingPoint>, h: Halfway) -> f32 {
    let beyond = 2.0 * (*point).roughness * h.LdotH * h.LdotH - 0.5;
    let light_scatter = 1.0 + beyond * fifth_power(1.0 - h.NdotL);
    let view_scatter = 1.0 + beyond * view_fresnel(point);
    return light_scatter * view_scatter * h.NdotL;
}

/// Specular reflection without the Fresnel term, times N·L. `view_smith` is that of `roughness`, `L` the direction of the light's centre.
fn specular_reflection(
    point: ptr<function, ShadingPoint>,
    L: vec3<f32>,
    h: Halfway,
    roughness: f32,
    view_smith: f32,
) -> f32 {
#ifdef STANDARD_MATERIAL_ANISOTROPY
    if (*point).is_anisotropic {
        let T = (*point).tangent;
        let B = bitangent_at(point);
        let V = (*point).V;
        let across = roughness * roughness;
        let along = mix(across, 1.0, (*point).anisotropy * (*point).anisotropy);
        let distribution = D_GGX_anisotropic(along, across, h.NdotH, dot(T, h.H), dot(B, h.H));
        let visibility = V_GGX_anisotropic(
            along, across, h.NdotL, view_cosine(point), dot(B, V), dot(T, V), dot(T, L), dot(B, L),
        );
        return distribution * visibility * h.NdotL;
    }
#endif
    // Distribution and visibility with one division.
    let square = roughness * roughness;
    let k = 1.0 - h.NdotH * h.NdotH * (1.0 - square);
    let lambdas = h.NdotL * view_smith + view_cosine(point) * smith(roughness, h.NdotL);
    return (0.5 * INVERSE_PI) * square * h.NdotL / (k * k * lambdas);
}

#ifdef STANDARD_MATERIAL_CLEARCOAT
/// Adds the clear coat: it reflects light, scaled by `dimming`, and attenuates the light that passes through it.
fn cover(
    point: ptr<function, ShadingPoint>,
    response: ptr<function, Response>,
    h: Halfway,
    roughness: f32,
    dimming: f32,
) {
    if (*point).clearcoat == 0.0 {
        return;
    }
    let fresnel = (0.04 + 0.96 * fifth_power(1.0 - h.LdotH)) * (*point).clearcoat;
    // Kelemen and Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model".
    // Clamp: infinity × 0 is NaN.
    let visibility = 0.25 / max(h.LdotH * h.LdotH, 1e-7);
    let passed = 1.0 - fresnel;
    (*response).diffuse *= passed;
    (*response).specular *= passed * passed;
    (*response).fresnel *= passed * passed;
    (*response).coat = distribution(roughness, h.NdotH) * visibility * fresnel * h.NdotL * dimming;
}
#endif

/// Response to light from the single direction `L`.
fn response(point: ptr<function, ShadingPoint>, L: vec3<f32>) -> Response {
    let h = halfway_to(point, L);
    var response: Response;
    response.diffuse = diffuse_reflection(point, h);
    let roughness = (*point).roughness;
    // From the cosine per light: fewer registers are live in the loops over lights.
    let view_smith = smith(roughness, view_cosine(point));
    response.specular = specular_reflection(point, L, h, roughness, view_smith);
    response.fresnel = response.specular * fifth_power(1.0 - h.LdotH);
#ifdef STANDARD_MATERIAL_CLEARCOAT
    cover(point, &response, h, (*point).clearcoat_roughness, 1.0);
#endif
    return response;
}

#ifdef SPHERE_LIGHTS
/// Response to a sphere light whose centre is `to_light` away: light from its point nearest to the mirrored ray, on a rougher
/// surface (Karis 2013, "Real Shading in Unreal Engine 4"), as amended by Bevy.
fn response_to_sphere(point: ptr<function, ShadingPoint>, to_light: vec3<f32>, radius: f32) -> Response {
    let distance = max(length(to_light), 1e-10);
    let L = to_light / distance;
    let R = reflect(-(*point).V, (*point).N);
    let to_ray = max(0.0001, dot(to_light, R)) * R - to_light;
    let nearest = to_light + to_ray * saturate(radius * inverseSqrt(max(dot(to_ray, to_ray), LEAST_SQUARE)));
    let h = halfway(point, unit(nearest));
    // Part of the sphere above the horizon.
    let solid_angle = radius * radius / (distance * distance);
    let above = saturate(h.NdotL / max(h.NdotL + solid_angle, 1e-4));

    let widening = radius / (2.0 * distance);
    let wide = widened((*point).roughness, widening);
    let view_smith = smith(wide.roughness, view_cosine(point));
    var response: Response;
    response.diffuse = diffuse_reflection(point, halfway(point, L));
    response.specular = specular_reflection(point, L, h, wide.roughness, view_smith) * wide.dimming * above;
    response.fresnel = response.specular * fifth_power(1.0 - h.LdotH);
#ifdef STANDARD_MATERIAL_CLEARCOAT
    let wide_coat = widened((*point).clearcoat_roughness, widening);
    cover(point, &response, h, wide_coat.roughness, wide_coat.dimming * above);
#endif
    return response;
}

struct Widened {
    roughness: f32,
    dimming: f32,
}

fn widened(roughness: f32, widening: f32) -> Widened {
    let wide = saturate(roughness + widening);
    let ratio = roughness / wide;
    return Widened(mix(roughness, wide, specular_fix_remap(roughness)), ratio * ratio);
}
#endif  // SPHERE_LIGHTS

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
/// Diffuse response to light from behind in direction `L`, at roughness 1 and times π.
fn response_from_behind(point: ptr<function, ShadingPoint>, L: vec3<f32>) -> f32 {
    let H = unit(L - (*point).V);
    let NdotL = saturate(-dot((*point).N, L));
    let LdotH = saturate(dot(L, H));
    let light_scatter = 1.0 + (2.0 * LdotH * LdotH - 0.5) * fifth_power(1.0 - NdotL);
    return light_scatter * NdotL;
}
#endif
