// Distance fog of Bevy (`fog.wgsl` of `bevy_pbr`), without the light that it scatters from directional lights.
#define_import_path bevy_lean_deferred::distance_fog

/// Distance fog of a view.
struct FogUniform {
    /// Light of dense fog, as in the picture. Alpha is the share of a surface's light that dense fog replaces.
    color: vec4<f32>,
    /// Per metre and channel; for linear fog, the distances in metres at which it begins and ends.
    extinction: vec3<f32>,
    /// `CLEAR`, `LINEAR`, `EXPONENTIAL`, or exponential in the square of the distance.
    mode: u32,
    /// As `extinction`, but for the fog's own light.
    inscattering: vec3<f32>,
}

/// No fog.
const CLEAR: u32 = 0u;
const LINEAR: u32 = 1u;
const EXPONENTIAL: u32 = 2u;

/// Least transmittance by which light is divided. Light of surfaces in denser fog is less than the rounding errors of the fog's own,
/// which half floats hold with eleven bits.
const LEAST_TRANSMITTANCE: f32 = 1.0 / 64.0;

/// Share of dense fog after `metres`, where it has this `strength`: `extinction` or `inscattering`.
fn density_of(fog: FogUniform, strength: vec3<f32>, metres: f32) -> vec3<f32> {
    var share: vec3<f32>;
    if fog.mode == LINEAR {
        share = vec3(1.0 - saturate((strength.y - metres) / (strength.y - strength.x)));
    } else {
        let depth = strength * metres;
        share = 1.0 - exp(-select(depth * depth, depth, fog.mode == EXPONENTIAL));
    }
    return share * fog.color.a;
}

/// Share of a surface's light that is left after `metres`.
fn transmittance(fog: FogUniform, metres: f32) -> vec3<f32> {
    return 1.0 - density_of(fog, fog.extinction, metres);
}

/// Light of the fog itself along `metres`.
fn fog_light(fog: FogUniform, metres: f32) -> vec3<f32> {
    return fog.color.rgb * density_of(fog, fog.inscattering, metres);
}

/// Light of a surface that a picture shows as `seen` after `metres` of fog. The picture was multiplied by `exposure_ratio` since; fog is
/// not exposed.
fn without_fog(fog: FogUniform, seen: vec3<f32>, metres: f32, exposure_ratio: f32) -> vec3<f32> {
    let transmitted = max(seen - exposure_ratio * fog_light(fog, metres), vec3(0.0));
    return transmitted / max(transmittance(fog, metres), vec3(LEAST_TRANSMITTANCE));
}

/// Light that a mirror `to_mirror` metres away receives from a surface without fog, before the fog in front of the mirror: with that,
/// the light has the fog of its whole `path` once.
fn fogged_in_mirror(fog: FogUniform, light: vec3<f32>, to_mirror: f32, path: f32) -> vec3<f32> {
    let along_path = light * transmittance(fog, path) + fog_light(fog, path) - fog_light(fog, to_mirror);
    return max(along_path, vec3(0.0)) / max(transmittance(fog, to_mirror), vec3(LEAST_TRANSMITTANCE));
}
