//! Lights of a level.

use bevy::prelude::*;

use super::file::Level;

/// Illuminance of the sun of a glTF file without any light and without `level.json`, in lux.
const DEFAULT_SUN: f32 = 8_000.0;

fn linear([red, green, blue]: [f32; 3]) -> Color {
    Color::linear_rgb(red, green, blue)
}

/// Undoes that Bevy's loader reads the linear colours of `KHR_lights_punctual` as sRGB.
fn as_linear(color: &mut Color) {
    *color = linear(color.to_srgba().to_f32_array_no_alpha());
}

/// Corrects the lights that the glTF file has, and spawns those of `level.json`. In a level with lightmaps, no light adds to the diffuse
/// light of lightmapped meshes: the maps have it. Returns the number of point and spot lights.
pub(super) fn set_up_lights(world: &mut World, level: &Level, has_lightmaps: bool) -> usize {
    let (mut clustered, mut directional) = (0, 0);
    let mut points = world.query::<&mut PointLight>();
    for mut light in points.iter_mut(world) {
        as_linear(&mut light.color);
        light.affects_lightmapped_mesh_diffuse = !has_lightmaps;
        clustered += 1;
    }
    let mut spots = world.query::<&mut SpotLight>();
    for mut light in spots.iter_mut(world) {
        as_linear(&mut light.color);
        // Bevy's loader sets it to the range.
        light.radius = 0.0;
        light.affects_lightmapped_mesh_diffuse = !has_lightmaps;
        clustered += 1;
    }
    let mut suns = world.query::<&mut DirectionalLight>();
    for mut light in suns.iter_mut(world) {
        as_linear(&mut light.color);
        light.affects_lightmapped_mesh_diffuse = !has_lightmaps;
        directional += 1;
    }
    for sun in &level.file.suns {
        let to_sun = Vec3::from(sun.to_sun);
        world.spawn((
            DirectionalLight {
                color: linear(sun.color),
                illuminance: sun.lux,
                shadow_maps_enabled: true,
                affects_lightmapped_mesh_diffuse: !has_lightmaps,
                ..default()
            },
            Transform::default().looking_to(-to_sun, Vec3::Y),
        ));
    }
    if !level.has_file && clustered + directional == 0 {
        world.spawn((
            DirectionalLight {
                illuminance: DEFAULT_SUN,
                shadow_maps_enabled: true,
                ..default()
            },
            Transform::from_xyz(3.0, 8.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
    }
    if let Some(ambient) = level.file.ambient {
        world.insert_resource(GlobalAmbientLight {
            color: linear(ambient),
            brightness: 1.0,
            affects_lightmapped_meshes: !has_lightmaps,
        });
    }
    if let Some(sky) = level.file.sky {
        world.insert_resource(ClearColor(linear(sky)));
    }
    clustered
}
