// Contact shadows of small nearby occluders: Bevy's ray march through the depth buffer.
#define_import_path bevy_lean_deferred::lighting::bevy::contact_shadow

#import bevy_lean_deferred::lighting::lights::shading_point::ShadingPoint
#import bevy_lean_deferred::lighting::parts
#import bevy_pbr::mesh_view_bindings::contact_shadows_settings
#import bevy_pbr::pbr_functions::calculate_contact_shadow

/// 0 where light from direction `L` is occluded.
fn contact_shadow(point: ptr<function, ShadingPoint>, L: vec3<f32>) -> f32 {
    let steps = contact_shadows_settings.linear_steps;
    if steps == 0u || !parts::has(parts::CONTACT_SHADOWS) {
        return 1.0;
    }
    let coordinates = vec2<f32>((*point).pixel) + 0.5;
    return calculate_contact_shadow((*point).position, coordinates, L, steps);
}
