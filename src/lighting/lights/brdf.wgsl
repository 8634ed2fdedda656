// How a surface reflects light from one direction: Bevy's `lighting` for one light, diffuse and specular apart, with what
// all lights share found once. `D_GGX` and others there say where each term is from.
#define_import_path bevy_lean_deferred::lighting::lights::brdf

#import bevy_lean_deferred::lighting::lights::lit::Lit
#import bevy_lean_deferred::lighting::lights::shading_point::{ShadingPoint, fifth_power, smith}
#import bevy_pbr::lighting::specular_fix_remap

#ifdef STANDARD_MATERIAL_ANISOTROPY
#import bevy_pbr::lighting::{D_GGX_anisotropic, V_GGX_anisotropic}
#endif

const INVERSE_PI: f32 = 0.31830987;

/// The normal and the directions of light and view beside the one halfway between these two.
struct Halfway {
    H: vec3<f32>,
    /// At least 0, as the others.
    NdotL: f32,
    NdotH: f32,
    LdotH: f32,
}

fn halfway(point: ptr<function, ShadingPoint>, L: vec3<f32>) -> Halfway {
    let H = normalize(L + (*point).V);
    let N = (*point).N;
    return Halfway(H, saturate(dot(N, L)), saturate(dot(N, H)), saturate(dot(L, H)));
}

/// The distribution of microfacets, 1/sr (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces").
fn distribution(roughness: f32, NdotH: f32) -> f32 {
    let a = NdotH * roughness;
    let k = roughness / (1.0 - NdotH * NdotH + a * a);
    return k * k * INVERSE_PI;
}

/// Diffuse reflection per colour, times π (Burley 2012, "Physically-Based Shading at Disney"), and times N·L.
fn diffuse_reflection(point: ptr<function, ShadingPoint>, h: Halfway) -> f32 {
    let beyond = 2.0 * (*point).roughness * h.LdotH * h.LdotH - 0.5;
    let light_scatter = 1.0 + beyond * fifth_power(1.0 - h.NdotL);
    let view_scatter = 1.0 + beyond * (*point).view_fresnel;
    return light_scatter * view_scatter * h.NdotL;
}

/// Specular reflection times N·L. `view_smith` is that of `roughness`. `L` is the direction of the light's centre.
fn specular_reflection(
    point: ptr<function, ShadingPoint>,
    L: vec3<f32>,
    h: Halfway,
    roughness: f32,
    view_smith: f32,
) -> vec3<f32> {
    let fresnel = (*point).F_normal + ((*point).F_grazing - (*point).F_normal) * fifth_power(1.0 - h.LdotH);
    let tint = fresnel * (*point).multiscatter;
#ifdef STANDARD_MATERIAL_ANISOTROPY
    if (*point).is_anisotropic {
        let T = (*point).tangent;
        let B = (*point).bitangent;
        let V = (*point).V;
        let across = roughness * roughness;
        let along = mix(across, 1.0, (*point).anisotropy * (*point).anisotropy);
        let distribution = D_GGX_anisotropic(along, across, h.NdotH, dot(T, h.H), dot(B, h.H));
        let visibility = V_GGX_anisotropic(
            along, across, h.NdotL, (*point).NdotV, dot(B, V), dot(T, V), dot(T, L), dot(B, L),
        );
        return tint * (distribution * visibility * h.NdotL);
    }
#endif
    let lambdas = h.NdotL * view_smith + (*point).NdotV * smith(roughness, h.NdotL);
    return tint * (distribution(roughness, h.NdotH) * 0.5 * h.NdotL / lambdas);
}

#ifdef STANDARD_MATERIAL_CLEARCOAT
/// What a clear coat reflects, times N·L, and what it lets through either way.
struct Coat {
    reflected: f32,
    passed: f32,
}

fn coat(point: ptr<function, ShadingPoint>, h: Halfway, roughness: f32) -> Coat {
    let fresnel = (0.04 + 0.96 * fifth_power(1.0 - h.LdotH)) * (*point).clearcoat;
    let visibility = 0.25 / (h.LdotH * h.LdotH);
    let reflected = distribution(roughness, h.NdotH) * visibility * fresnel * h.NdotL;
    return Coat(reflected, 1.0 - fresnel);
}
#endif

/// Of light from the one direction `L`.
fn reflected(point: ptr<function, ShadingPoint>, L: vec3<f32>) -> Lit {
    let h = halfway(point, L);
    var lit: Lit;
    lit.diffuse = (*point).diffuse_color * (diffuse_reflection(point, h) * INVERSE_PI);
    lit.specular = specular_reflection(point, L, h, (*point).roughness, (*point).view_smith);
#ifdef STANDARD_MATERIAL_CLEARCOAT
    if (*point).clearcoat > 0.0 {
        let coat = coat(point, h, (*point).clearcoat_roughness);
        lit.diffuse *= coat.passed;
        lit.specular = lit.specular * (coat.passed * coat.passed) + coat.reflected;
    }
#endif
    return lit;
}

/// Of light from a sphere whose centre is `to_light`, as far as `distance`, away: as if its point nearest to the mirrored
/// ray shone, on a rougher surface (Karis 2013, "Real Shading in Unreal Engine 4"), as Bevy amends it.
fn reflected_sphere(
    point: ptr<function, ShadingPoint>,
    to_light: vec3<f32>,
    distance: f32,
    radius: f32,
) -> Lit {
    let L = to_light / distance;
    let R = (*point).R;
    let to_ray = max(0.0001, dot(to_light, R)) * R - to_light;
    let nearest = to_light + to_ray * saturate(radius * inverseSqrt(dot(to_ray, to_ray)));
    let h = halfway(point, nearest * inverseSqrt(dot(nearest, nearest)));
    // The part of the sphere above the horizon.
    let solid_angle = radius * radius / (distance * distance);
    let above = saturate(h.NdotL / max(h.NdotL + solid_angle, 1e-4));

    let widening = radius / (2.0 * distance);
    let wide = widened((*point).roughness, widening);
    var lit: Lit;
    lit.diffuse = (*point).diffuse_color * (diffuse_reflection(point, halfway(point, L)) * INVERSE_PI);
    let view_smith = smith(wide.roughness, (*point).NdotV);
    lit.specular = specular_reflection(point, L, h, wide.roughness, view_smith) * (wide.dimming * above);
#ifdef STANDARD_MATERIAL_CLEARCOAT
    if (*point).clearcoat > 0.0 {
        let wide_coat = widened((*point).clearcoat_roughness, widening);
        let coat = coat(point, h, wide_coat.roughness);
        // Bevy dims what the coat reflects, but not what it takes away.
        lit.diffuse *= coat.passed;
        lit.specular = lit.specular * (coat.passed * coat.passed)
            + coat.reflected * (wide_coat.dimming * above);
    }
#endif
    return lit;
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

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
/// Light from behind, in direction `L`, that shines through: diffuse, of roughness 1.
fn transmitted(point: ptr<function, ShadingPoint>, L: vec3<f32>) -> vec3<f32> {
    let H = normalize(L - (*point).V);
    let NdotL = saturate(-dot((*point).N, L));
    let LdotH = saturate(dot(L, H));
    let light_scatter = 1.0 + (2.0 * LdotH * LdotH - 0.5) * fifth_power(1.0 - NdotL);
    return (*point).transmitted_color * (light_scatter * NdotL * INVERSE_PI);
}
#endif
