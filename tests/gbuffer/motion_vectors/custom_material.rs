//! A material whose vertex shader moves it: the water of the example `custom_material`.

use core::time::Duration;

use bevy::{light::NotShadowCaster, prelude::*};
use bevy_lean_deferred::prelude::*;
use kit::{headless::small_shadow_maps, own_process::in_own_process};

use super::{case::Case, scene, taa, turn_camera};

#[path = "../../../examples/custom_material/main.rs"]
#[expect(dead_code, reason = "of the example, only the material is tested")]
mod example;

use example::Water;

/// Period of the time that shaders see.
const HOUR: Duration = Duration::from_secs(3600);

/// Begins the next hour.
fn restart_time(world: &mut World) {
    let mut time = world.resource_mut::<Time<Virtual>>();
    let hours = time.elapsed().as_secs() / HOUR.as_secs() + 1;
    time.advance_to(HOUR * hours as u32);
}

#[test]
fn animated_vertices() {
    in_own_process(|| {
        let case = Case::new(
            "animated_vertices",
            |s| {
                scene(s, taa());
                let mesh = s.add::<Mesh>(Plane3d::default().mesh().size(8.0, 8.0).subdivisions(63));
                let water = s.add::<Water>(Water {
                    color: LinearRgba::rgb(0.02, 0.1, 0.12),
                    height: 0.15,
                });
                s.spawn((
                    Mesh3d(mesh),
                    MeshMaterial3d(water),
                    NotShadowCaster,
                    Transform::from_xyz(0.0, 0.4, 0.0),
                ));
            },
            |world, frame| {
                // Both films show the same waves.
                if frame == 0 {
                    restart_time(world);
                }
                turn_camera(world, frame as f32 * 0.005);
            },
        );
        let targets = Case {
            configure: |app| {
                small_shadow_maps(app);
                app.add_plugins((
                    MaterialPlugin::<Water>::default(),
                    GBufferMaterialPlugin::<Water>::default(),
                ));
            },
            ..case
        }
        .compare();
        assert_eq!(targets.len(), 8, "the mesh always writes motion");
    });
}
