//! Meshes in the G-buffer stay visible while pipelines compile for what they newly need.
//!
//! In a process of its own: compilation is delayed in all of the process.

use bevy::{
    core_pipeline::prepass::MotionVectorPrepass,
    light::ShadowFilteringMethod,
    pbr::{ContactShadows, DistanceFog},
    prelude::*,
};
use bevy_lean_deferred::{LeanDeferred, lighting::CompiledLighting};
use kit::{
    headless::{Headless, small_shadow_maps},
    lean::{active_lean_views, compile_lighting},
    log_watch,
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::SceneBuilder,
    stalled_pipelines::StalledPipelines,
};

use super::no_stutter::set_material;

const SIZE: UVec2 = UVec2::new(96, 64);
/// Frames after a change for which compilation is delayed, and frames after that which are looked at.
const HELD_BACK: usize = 4;
/// PSNR in dB, below which the ball is missing: it covers a tenth of the picture.
const ALIKE: f64 = 23.5;

struct Subject {
    camera: Entity,
    ball: Entity,
    material: Handle<StandardMaterial>,
}

type Change = fn(&mut World, &Subject);

/// Changes that need other targets or pipelines. Bevy's forward pass draws the ball in all frames of each.
const CHANGES: [(&str, Change); 4] = [
    ("it begins to move", |world, subject| {
        let mut place = world.get_mut::<Transform>(subject.ball).expect("placed");
        place.translation.x += 0.02;
    }),
    ("emission", |world, subject| {
        set_material(world, &subject.material, |material| {
            material.emissive = LinearRgba::rgb(0.2, 0.6, 0.2);
        });
    }),
    ("reflectance", |world, subject| {
        set_material(world, &subject.material, |material| {
            material.reflectance = 0.9
        });
    }),
    ("unlit", |world, subject| {
        set_material(world, &subject.material, |material| material.unlit = true);
    }),
];

fn build(headless: &mut Headless) -> Subject {
    let mut s = SceneBuilder { headless };
    s.solids();
    s.sun(true);
    let material = s.add::<StandardMaterial>(Color::srgb(0.9, 0.2, 0.7));
    let mesh = s.add::<Mesh>(Sphere::new(0.8));
    let ball = s.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material.clone()),
        Transform::from_xyz(0.0, 0.8, 1.6),
    ));
    let camera = s.default_camera((LeanDeferred::default(), MotionVectorPrepass));
    Subject {
        camera,
        ball,
        material,
    }
}

/// Changes the key of all pipelines of Bevy's, so that none is compiled for meshes in the G-buffer.
const OTHER_KEYS: [fn(&mut EntityWorldMut); CHANGES.len()] = [
    |camera| {
        camera.insert(DistanceFog::default());
    },
    |camera| {
        camera.insert(ShadowFilteringMethod::Hardware2x2);
    },
    |camera| {
        camera.remove::<DistanceFog>();
    },
    |camera| {
        camera.insert(ContactShadows::default());
    },
];

/// Delays compilation after the change, and fails for each frame that resembles neither the picture before it nor that after it.
fn check(
    name: &str,
    headless: &mut Headless,
    subject: &Subject,
    change: impl FnOnce(&mut World, &Subject),
) -> Vec<String> {
    let before = headless.capture();
    let mut stalled = Some(StalledPipelines::new());
    change(headless.world(), subject);
    let film = headless.film(3 * HELD_BACK, |_, frame| {
        if frame == HELD_BACK {
            stalled = None;
        }
    });
    headless.settle();
    let after = headless.capture();
    let mut vanished = Vec::new();
    for (frame, picture) in film.iter().enumerate() {
        let psnr = [&before, &after].map(|other| pixel_difference(other, picture).psnr);
        println!("{name}, frame {frame}: {psnr:.1?} dB from before and after");
        if psnr.into_iter().all(|psnr| psnr < ALIKE) {
            vanished.push(format!("{name}, frame {frame}: {psnr:.1?} dB"));
        }
    }
    vanished
}

#[test]
fn meshes_stay_visible_while_their_pipelines_compile() {
    in_own_process(|| {
        let mut headless = Headless::with_compilation(SIZE, false, |app| {
            small_shadow_maps(app);
            compile_lighting(app, CompiledLighting::All);
        });
        let subject = build(&mut headless);
        headless.settle();
        headless.frames(4);
        assert_eq!(active_lean_views(&mut headless), 1);
        let mut vanished = Vec::new();
        // Neither the pipelines of the G-buffer are compiled nor Bevy's.
        for ((name, change), other_key) in CHANGES.into_iter().zip(OTHER_KEYS) {
            let name = format!("{name}, with another key");
            vanished.extend(check(&name, &mut headless, &subject, |world, subject| {
                other_key(&mut world.entity_mut(subject.camera));
                change(world, subject);
            }));
        }
        // Bevy's pipelines are compiled in the background.
        let flash: Change = |world, subject| {
            set_material(world, &subject.material, |material| {
                material.unlit = false;
                material.base_color = Color::linear_rgb(3.0, 1.0, 1.0);
            });
        };
        vanished.extend(check("values out of range", &mut headless, &subject, flash));
        let disabled: Change = |world, subject| {
            let mut lean = world.get_mut::<LeanDeferred>(subject.camera).expect("lean");
            lean.enabled = false;
        };
        vanished.extend(check("disabled", &mut headless, &subject, disabled));
        assert!(vanished.is_empty(), "not visible: {vanished:#?}");
        log_watch::assert_validation_layer_silent();
    });
}
