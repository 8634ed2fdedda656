// The weight of a light probe, for loops over reflection probes and irradiance volumes. In its own space a probe is a cube of edge 1
// around the origin.
#define_import_path bevy_lean_deferred::lighting::lights::light_probe

/// Weight of a probe at `place` in its own space: ramps from 0 at the faces to 1 within, over `falloff`.
fn weight_in_probe(place: vec3<f32>, falloff: vec3<f32>) -> f32 {
    let ramps = saturate((1.0 - 2.0 * abs(place)) / (2.0 * max(falloff, vec3(0.0001))));
    return min(min(ramps.x, ramps.y), ramps.z);
}
