//! The vectors themselves, for everything that can move.

use bevy::{
    camera::{ScalingMode, Viewport},
    core_pipeline::prepass::MotionVectorPrepass,
    mesh::morph::MeshMorphWeights,
    prelude::*,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    lean::{build, set_lean},
    log_watch,
    own_process::in_own_process,
    scenes::meshes::{morphed, skinned},
    skipped::on_swiftshader,
};

use super::{
    Mover, SIZE,
    case::{Case, LARGEST, RMS, errors, film},
    move_all, probe, scene, shift_movers, still_and_moving, taa, turn_camera,
};

/// In its first frame of motion Bevy's prepass draws a mesh; from then on the view has a target.
#[test]
fn moving_meshes() {
    in_own_process(|| {
        let targets = Case::new(
            "moving_meshes",
            |s| still_and_moving(s, taa()),
            |world, frame| {
                turn_camera(world, frame as f32 * 0.005);
                if frame >= 3 {
                    shift_movers(world, Vec3::new(0.05, 0.02, -0.03));
                }
            },
        )
        .compare();
        assert_eq!(targets, [4, 5, 6, 7]);
    });
}

/// Materials of this crate and of others pack their motion as `StandardMaterial` does.
#[test]
#[ignore = "nightly: further materials in motion"]
fn moving_extended_materials() {
    in_own_process(|| {
        let rim = ShadingExtension::Rim {
            color: Color::WHITE,
            exponent: 4.0,
        };
        let subsurface = ShadingExtension::Subsurface {
            color: Color::WHITE,
            mean_free_path: 0.02,
            albedo: default(),
        };
        let targets = Case::new(
            "moving_extended_materials",
            |s| {
                scene(s, taa());
                let mesh = s.add::<Mesh>(Sphere::new(0.4).mesh().uv(32, 16));
                for (extension, x) in [
                    (rim, -0.9),
                    (subsurface, 0.0),
                    (ShadingExtension::None, 0.9),
                ] {
                    let material = s.add::<ExtendedStandardMaterial>(ExtendedStandardMaterial {
                        base: Color::srgb(0.9, 0.6, 0.2).into(),
                        extension,
                    });
                    s.spawn((
                        Mesh3d(mesh.clone()),
                        MeshMaterial3d(material),
                        Transform::from_xyz(x, 1.0, 1.0),
                        Mover,
                    ));
                }
            },
            |world, frame| {
                turn_camera(world, frame as f32 * 0.005);
                shift_movers(world, Vec3::new(0.05, 0.02, -0.03));
            },
        )
        .compare();
        assert_eq!(targets, [1, 2, 3, 4, 5, 6, 7]);
    });
}

#[test]
fn skinned_mesh() {
    in_own_process(|| {
        let targets = Case::new(
            "skinned_mesh",
            |s| {
                scene(s, taa());
                let joint = skinned(s);
                s.world().entity_mut(joint).insert(Mover);
            },
            |world, frame| {
                turn_camera(world, frame as f32 * 0.005);
                let mut joints = world.query_filtered::<&mut Transform, With<Mover>>();
                for mut joint in joints.iter_mut(world) {
                    joint.rotate_local_z(0.05);
                }
            },
        )
        .compare();
        assert_eq!(targets.len(), 8);
    });
}

#[test]
fn morphed_mesh() {
    in_own_process(|| {
        let targets = Case::new(
            "morphed_mesh",
            |s| {
                scene(s, taa());
                morphed(s);
            },
            |world, frame| {
                turn_camera(world, frame as f32 * 0.005);
                let mut weights = world.query::<&mut MeshMorphWeights>();
                for mut weights in weights.iter_mut(world) {
                    *weights = MeshMorphWeights::Value {
                        weights: vec![0.5 - frame as f32 * 0.04, 0.8 - frame as f32 * 0.05],
                    };
                }
            },
        )
        .compare();
        assert_eq!(targets.len(), 8);
    });
}

/// After the camera jumps, vectors stay within the tolerance: surfaces beside the former camera were infinitely far outside its picture.
#[test]
fn teleporting_camera() {
    in_own_process(|| {
        let (errors, _) = Case::new(
            "teleporting_camera",
            |s| still_and_moving(s, taa()),
            |world, frame| turn_camera(world, if frame == 4 { 2.5 } else { 0.0 }),
        )
        .measure();
        let most = on_swiftshader(
            f32::INFINITY,
            1.0,
            "motion where the divisor of a former place is next to 0",
        );
        assert!(errors.largest_share <= most, "{errors:?}");
    });
}

#[test]
fn viewport() {
    in_own_process(|| {
        let camera = || Camera {
            viewport: Some(Viewport {
                physical_position: UVec2::new(37, 21),
                physical_size: UVec2::new(201, 155),
                ..default()
            }),
            ..default()
        };
        Case::new(
            "viewport",
            |s| still_and_moving(s, (MotionVectorPrepass, camera())),
            move_all,
        )
        .compare();
    });
}

#[test]
#[ignore = "nightly: another projection"]
fn orthographic() {
    in_own_process(|| {
        let projection = || {
            Projection::Orthographic(OrthographicProjection {
                scaling_mode: ScalingMode::FixedVertical {
                    viewport_height: 5.0,
                },
                ..OrthographicProjection::default_3d()
            })
        };
        let (errors, _) = Case::new(
            "orthographic",
            |s| still_and_moving(s, (taa(), projection())),
            move_all,
        )
        .measure();
        // The background moves by hundreds of pixels, in forward too.
        assert!(errors.largest <= LARGEST && errors.rms <= RMS, "{errors:?}");
    });
}

/// Lean matches forward from the first frame of the app on, while meshes load and nothing has a history.
#[test]
fn first_frames() {
    in_own_process(|| {
        let films = [false, true].map(|lean| {
            let mut headless = build(SIZE, |s| still_and_moving(s, taa()));
            probe::install(&mut headless);
            set_lean(&mut headless, lean);
            film(&mut headless, 10, move_all)
        });
        let errors = errors(&films[0], &films[1]);
        println!("first_frames {errors:?}");
        assert!(films[1][9].has_motion_target(), "lean by then");
        assert!(
            errors.longest > 1.0 && errors.largest <= LARGEST,
            "{errors:?}"
        );
        log_watch::assert_validation_layer_silent();
    });
}
