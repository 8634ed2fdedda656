//! The motion vectors of a lean camera are those that Bevy's prepass writes.

mod common;
#[path = "motion_vectors/probe.rs"]
mod probe;

use bevy::{
    anti_alias::taa::TemporalAntiAliasing,
    camera::{ScalingMode, Viewport},
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
    diagnostic::FrameCount,
    material::OpaqueRendererMethod,
    mesh::morph::MeshMorphWeights,
    post_process::motion_blur::MotionBlur,
    prelude::*,
    render::{
        RenderApp, camera::DirtySpecializations, occlusion_culling::OcclusionCulling,
        sync_world::MainEntity,
    },
};
use bevy_lean_deferred::{camera::ActiveLeanView, gbuffer::GBufferTextures, prelude::*};
use common::{
    headless::{Headless, log_watch},
    lean::{build, judge, report, set_lean},
    scenes::{
        LEAST_PSNR, SceneBuilder,
        meshes::{morphed, skinned},
    },
};

const SIZE: UVec2 = UVec2::new(320, 240);
const FRAMES: usize = 8;

/// What moves.
#[derive(Component)]
struct Mover;

/// What a scene may have, and what happens in it.
type Script = fn(&mut World, usize);

fn camera_transform(angle: f32) -> Transform {
    let (sin, cos) = angle.sin_cos();
    Transform::from_xyz(6.0 * sin, 2.5, 6.0 * cos).looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y)
}

/// Solids of the G-buffer; balls that only forward draws in front of and behind them, and one that cuts through the
/// floor; an alpha-masked and an emissive one. Sky beyond.
fn scene(s: &mut SceneBuilder, camera: impl Bundle) {
    s.solids();
    s.sun(false);
    for (x, z) in [(-2.0, 1.8), (0.2, -2.4), (2.6, 0.8)] {
        s.mesh(
            Sphere::new(0.5),
            StandardMaterial {
                opaque_render_method: OpaqueRendererMethod::Forward,
                ..Color::srgb(0.4, 0.3, 0.7).into()
            },
            Transform::from_xyz(x, 0.3, z),
        );
    }
    let checker = s.checker([255; 4], [255, 255, 255, 0]);
    s.mesh(
        Rectangle::new(1.2, 1.2),
        StandardMaterial {
            base_color_texture: Some(checker),
            alpha_mode: AlphaMode::Mask(0.5),
            ..default()
        },
        Transform::from_xyz(-1.0, 0.8, 1.8),
    );
    s.mesh(
        Sphere::new(0.3),
        StandardMaterial {
            emissive: LinearRgba::rgb(0.2, 0.6, 0.2),
            ..default()
        },
        Transform::from_xyz(1.6, 0.3, 1.6),
    );
    s.camera(camera_transform(0.0), camera);
}

/// A lean and a forward-only ball that move, and behind the first a lean wall that does not.
fn movers(s: &mut SceneBuilder) {
    for (x, method) in [
        (0.0, OpaqueRendererMethod::Auto),
        (1.2, OpaqueRendererMethod::Forward),
    ] {
        let ball = s.mesh(
            Sphere::new(0.4),
            StandardMaterial {
                opaque_render_method: method,
                ..Color::srgb(0.9, 0.6, 0.2).into()
            },
            Transform::from_xyz(x, 1.0, 1.0),
        );
        s.world().entity_mut(ball).insert(Mover);
    }
}

fn turn_camera(world: &mut World, angle: f32) {
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    *cameras.single_mut(world).expect("one camera") = camera_transform(angle);
}

fn shift_movers(world: &mut World, by: Vec3) {
    let mut movers = world.query_filtered::<&mut Transform, With<Mover>>();
    for mut mover in movers.iter_mut(world) {
        mover.translation += by;
    }
}

/// Starts at the same phase of the jitter.
fn align(headless: &mut Headless) {
    headless.settle();
    while !headless
        .world()
        .resource::<FrameCount>()
        .0
        .is_multiple_of(8)
    {
        headless.frames(1);
    }
}

/// The view of the last frame, if it was lean.
fn active_view(headless: &mut Headless) -> Option<ActiveLeanView> {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<&ActiveLeanView>();
    views.iter(world).next().copied()
}

fn targets(headless: &mut Headless) -> GBufferTargets {
    active_view(headless).expect("a lean view").targets
}

/// What a frame showed.
struct Frame {
    motions: Vec<Vec2>,
    targets: Option<GBufferTargets>,
}

fn film(headless: &mut Headless, script: Script) -> Vec<Frame> {
    (0..FRAMES)
        .map(|frame| {
            script(headless.world(), frame);
            headless.frames(1);
            Frame {
                motions: probe::read(headless),
                targets: active_view(headless).map(|view| view.targets),
            }
        })
        .collect()
}

/// How far motion vectors are apart, in pixels.
#[derive(Default, Debug)]
struct Errors {
    largest: f32,
    rms: f64,
    /// The longest motion that there is.
    longest: f32,
    /// Pixels of which not all bits are equal.
    unequal: usize,
}

fn errors<'a>(forward: impl IntoIterator<Item = &'a Frame>, lean: &[Frame]) -> Errors {
    let mut errors = Errors::default();
    let mut sum = 0.0;
    let mut count = 0;
    for (forward, lean) in forward.into_iter().zip(lean) {
        for (a, b) in forward.motions.iter().zip(&lean.motions) {
            let error = ((*a - *b) * SIZE.as_vec2()).length();
            assert!(!error.is_nan(), "a motion is not a number: {a}, {b}");
            errors.largest = errors.largest.max(error);
            errors.longest = errors.longest.max((*a * SIZE.as_vec2()).length());
            errors.unequal += usize::from(a != b);
            sum += f64::from(error).powi(2);
            count += 1;
        }
    }
    errors.rms = (sum / f64::from(count)).sqrt();
    errors
}

/// How a comparison went: frames of forward and of lean, and what the lean view's targets were.
struct Comparison {
    forward: Vec<Frame>,
    lean: Vec<Frame>,
    errors: Errors,
}

/// Films forward, then lean with the same script.
fn compare(
    name: &str,
    mut make: impl FnMut(&mut SceneBuilder),
    script: Script,
    largest: f32,
    rms: f64,
) -> Comparison {
    let mut films = [false, true].map(|lean| {
        let mut headless = build(SIZE, &mut make);
        probe::install(&mut headless);
        set_lean(&mut headless, lean);
        align(&mut headless);
        let film = film(&mut headless, script);
        if let Some(view) = active_view(&mut headless) {
            assert!(view.resolves_motion && !view.keeps_prepass, "{view:?}");
        }
        film
    });
    let lean = core::mem::take(&mut films[1]);
    let forward = core::mem::take(&mut films[0]);
    assert!(
        lean.iter().all(|frame| frame.targets.is_some()),
        "{name}: not lean in each frame"
    );
    let errors = errors(&forward, &lean);
    println!("{name:24} {errors:?}");
    assert!(errors.longest > 1.0, "{name}: nothing moves");
    assert!(
        errors.largest <= largest && errors.rms <= rms,
        "{name}: {errors:?}, more than {largest} or {rms} pixels"
    );
    log_watch::assert_validation_layer_silent();
    Comparison {
        forward,
        lean,
        errors,
    }
}

impl Comparison {
    /// Frames in which the view had a motion target.
    fn frames_with_target(&self) -> Vec<usize> {
        let has_target = |frame: &Frame| {
            frame
                .targets
                .is_some_and(|targets| targets.contains(GBufferTargets::MOTION))
        };
        (0..self.lean.len())
            .filter(|&frame| has_target(&self.lean[frame]))
            .collect()
    }
}

/// In pixels of 320 × 240: what rounding to half floats does to motions up to some pixels, and to some hundred.
const LARGEST: f32 = 0.02;
const RMS: f64 = 0.002;

#[test]
fn moving_camera() {
    let film = compare(
        "moving_camera",
        |s| scene(s, TemporalAntiAliasing::default()),
        |world, frame| turn_camera(world, frame as f32 * 0.01),
        LARGEST,
        RMS,
    );
    assert_eq!(film.frames_with_target(), [0usize; 0], "nothing else moves");
}

#[test]
fn moving_meshes() {
    let film = compare(
        "moving_meshes",
        |s| {
            scene(s, TemporalAntiAliasing::default());
            movers(s);
        },
        |world, frame| {
            turn_camera(world, frame as f32 * 0.005);
            if frame >= 3 {
                shift_movers(world, Vec3::new(0.05, 0.02, -0.03));
            }
        },
        LARGEST,
        RMS,
    );
    assert_eq!(film.frames_with_target(), [4, 5, 6, 7]);
}

#[test]
fn skinned_mesh() {
    let film = compare(
        "skinned_mesh",
        |s| {
            scene(s, TemporalAntiAliasing::default());
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
        LARGEST,
        RMS,
    );
    assert_eq!(film.frames_with_target().len(), FRAMES);
}

#[test]
fn morphed_mesh() {
    let film = compare(
        "morphed_mesh",
        |s| {
            scene(s, TemporalAntiAliasing::default());
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
        LARGEST,
        RMS,
    );
    assert_eq!(film.frames_with_target().len(), FRAMES);
}

#[test]
fn teleports() {
    compare(
        "teleporting_camera",
        |s| scene(s, TemporalAntiAliasing::default()),
        |world, frame| turn_camera(world, if frame == 4 { 2.5 } else { 0.0 }),
        f32::INFINITY,
        f64::INFINITY,
    );
    compare(
        "teleporting_meshes",
        |s| {
            scene(s, TemporalAntiAliasing::default());
            movers(s);
        },
        |world, frame| {
            if frame == 4 {
                shift_movers(world, Vec3::new(-1.5, 0.8, -2.0));
            }
        },
        1.0,
        0.1,
    );
}

#[test]
fn viewport() {
    compare(
        "viewport",
        |s| {
            scene(
                s,
                (
                    DepthPrepass,
                    MotionVectorPrepass,
                    Camera {
                        viewport: Some(Viewport {
                            physical_position: UVec2::new(37, 21),
                            physical_size: UVec2::new(201, 155),
                            ..default()
                        }),
                        ..default()
                    },
                ),
            );
            movers(s);
        },
        |world, frame| {
            turn_camera(world, frame as f32 * 0.01);
            shift_movers(world, Vec3::new(0.05, 0.02, -0.03));
        },
        LARGEST,
        RMS,
    );
}

#[test]
fn orthographic() {
    compare(
        "orthographic",
        |s| {
            scene(
                s,
                (
                    TemporalAntiAliasing::default(),
                    Projection::Orthographic(OrthographicProjection {
                        scaling_mode: ScalingMode::FixedVertical {
                            viewport_height: 5.0,
                        },
                        ..OrthographicProjection::default_3d()
                    }),
                ),
            );
            movers(s);
        },
        |world, frame| {
            turn_camera(world, frame as f32 * 0.01);
            shift_movers(world, Vec3::new(0.05, 0.02, -0.03));
        },
        LARGEST,
        RMS,
    );
}
