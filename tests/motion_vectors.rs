//! The motion vectors of a lean camera are those that Bevy's prepass writes.

mod common;
#[path = "motion_vectors/probe.rs"]
mod probe;

use bevy::{
    anti_alias::taa::TemporalAntiAliasing,
    camera::{ScalingMode, Viewport},
    core_pipeline::{
        prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
        tonemapping::Tonemapping,
    },
    diagnostic::FrameCount,
    material::OpaqueRendererMethod,
    mesh::morph::MeshMorphWeights,
    post_process::motion_blur::MotionBlur,
    prelude::*,
    render::{
        RenderApp,
        camera::{DirtySpecializations, MipBias, TemporalJitter},
        occlusion_culling::OcclusionCulling,
        render_resource::TextureUsages,
    },
};
use bevy_lean_deferred::{
    gbuffer::{GBufferTextures, SortedMeshes},
    prelude::*,
    view::ActiveLeanView,
};
use common::{
    headless::{Headless, Picture, log_watch},
    lean::{build, judge, report, set_lean},
    scenes::{
        LEAST_PSNR, SceneBuilder,
        meshes::{morphed, skinned},
    },
};

const SIZE: UVec2 = UVec2::new(320, 240);

/// What moves.
#[derive(Component)]
struct Mover;

/// What happens before each frame.
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

/// A lean and a forward-only ball, to be moved.
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

/// Makes frames until all is loaded, and as many in each app: jitter and noise are then the same, and after enough of
/// them what temporal anti-aliasing has gathered.
fn align(headless: &mut Headless, frames: u32) {
    headless.settle();
    let made = headless.world().resource::<FrameCount>().0;
    let rest = frames.checked_sub(made).expect("loaded by then");
    headless.frames(rest as usize);
}

/// The view of the last frame, if it was lean.
fn active_view(headless: &mut Headless) -> Option<ActiveLeanView> {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<&ActiveLeanView>();
    views.iter(world).next().copied()
}

/// What a frame showed.
struct Frame {
    motions: Vec<Vec2>,
    view: Option<ActiveLeanView>,
}

impl Frame {
    fn has_motion_target(&self) -> bool {
        (self.view).is_some_and(|view| view.targets.contains(GBufferTargets::MOTION))
    }
}

fn film(headless: &mut Headless, frames: usize, script: Script) -> Vec<Frame> {
    (0..frames)
        .map(|frame| {
            script(headless.world(), frame);
            headless.frames(1);
            Frame {
                motions: probe::read(headless),
                view: active_view(headless),
            }
        })
        .collect()
}

/// How far motion vectors are apart, in pixels.
#[derive(Default, Debug)]
struct Errors {
    largest: f32,
    rms: f64,
    /// In terms of what [`inexactness`] allows.
    largest_share: f32,
    /// The longest motion that there is.
    longest: f32,
    /// Pixels of which not all bits are equal.
    unequal: usize,
}

fn errors(forward: &[Frame], lean: &[Frame]) -> Errors {
    let mut errors = Errors::default();
    let mut sum = 0.0;
    let mut count = 0;
    for (forward, lean) in forward.iter().zip(lean) {
        for (a, b) in forward.motions.iter().zip(&lean.motions) {
            let length = (*a * SIZE.as_vec2()).length();
            let error = ((*a - *b) * SIZE.as_vec2()).length();
            assert!(!error.is_nan(), "a motion is not a number: {a}, {b}");
            errors.largest = errors.largest.max(error);
            errors.largest_share = errors.largest_share.max(error / inexactness(length));
            errors.longest = errors.longest.max(length);
            errors.unequal += usize::from(a != b);
            sum += f64::from(error).powi(2);
            count += 1;
        }
    }
    errors.rms = (sum / f64::from(count)).sqrt();
    errors
}

/// A scene in motion, to be filmed forward and lean.
struct Case<F> {
    name: &'static str,
    make: F,
    script: Script,
    frames: usize,
    /// Whether the G-buffer gives the motion, not Bevy's prepass.
    resolves: bool,
}

/// In pixels of 320 × 240. Half floats have steps of 0.0024 pixels between motions of 2.5 and 5 pixels: largely, what is
/// between the two renderers is one such step where a motion lies between two of them.
const LARGEST: f32 = 0.005;
const RMS: f64 = 0.0005;

/// How far two renderers may be apart where the camera has gone elsewhere: by a step of half floats; by what GPUs round off
/// positions that they interpolate, as Bevy has them do, which cancels out only between cameras that are near each other;
/// and for surfaces beside the former camera, whose position there is divided by a w near 0, by what rounding leaves of
/// that: the longer the motion, the less.
fn inexactness(motion: f32) -> f32 {
    LARGEST.max(0.001 * motion) + 1e-6 * motion * motion
}

impl<F: FnMut(&mut SceneBuilder)> Case<F> {
    fn new(name: &'static str, make: F, script: Script) -> Self {
        Self {
            name,
            make,
            script,
            frames: 8,
            resolves: true,
        }
    }

    /// Films forward, then lean with the same script, and returns how far they are apart, and the lean frames.
    fn measure(mut self) -> (Errors, Vec<Frame>) {
        let [forward, lean] = [false, true].map(|lean| {
            let mut headless = build(SIZE, &mut self.make);
            probe::install(&mut headless);
            set_lean(&mut headless, lean);
            align(&mut headless, 64);
            film(&mut headless, self.frames, self.script)
        });
        assert!(forward.iter().all(|frame| frame.view.is_none()));
        for frame in &lean {
            let view = frame.view.expect("lean in each frame");
            assert_eq!(view.resolves_motion, self.resolves, "{view:?}");
            assert_eq!(view.keeps_prepass, !self.resolves, "{view:?}");
        }
        let errors = errors(&forward, &lean);
        println!("{:24} {errors:?}", self.name);
        assert!(errors.longest > 1.0, "{}: nothing moves", self.name);
        log_watch::assert_validation_layer_silent();
        (errors, lean)
    }

    /// Also asserts that the two agree. Returns the frames in which the lean view had a motion target.
    fn compare(self) -> Vec<usize> {
        let name = self.name;
        let (errors, lean) = self.measure();
        assert!(
            errors.largest <= LARGEST && errors.rms <= RMS,
            "{name}: {errors:?}"
        );
        (0..lean.len())
            .filter(|&frame| lean[frame].has_motion_target())
            .collect()
    }
}

fn taa() -> impl Bundle {
    TemporalAntiAliasing::default()
}

fn still_and_moving(s: &mut SceneBuilder, camera: impl Bundle) {
    scene(s, camera);
    movers(s);
}

fn move_all(world: &mut World, frame: usize) {
    turn_camera(world, frame as f32 * 0.01);
    shift_movers(world, Vec3::new(0.05, 0.02, -0.03));
}

#[test]
fn moving_camera() {
    let targets = Case::new(
        "moving_camera",
        |s| scene(s, taa()),
        |world, frame| turn_camera(world, frame as f32 * 0.01),
    )
    .compare();
    assert_eq!(targets, [0usize; 0], "nothing else moves");
}

/// In the first frame Bevy's prepass draws the mesh that moves; from then on the view has a target.
#[test]
fn moving_meshes() {
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
}

/// Materials of this crate and of others pack their motion as `StandardMaterial` does.
#[test]
fn moving_extended_materials() {
    let rim = ShadingExtension::Rim {
        color: Color::WHITE,
        exponent: 4.0,
    };
    let subsurface = ShadingExtension::Subsurface {
        color: Color::WHITE,
        mean_free_path: 0.02,
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
}

#[test]
fn skinned_mesh() {
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
}

#[test]
fn morphed_mesh() {
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
}

/// Surfaces beside the former camera were infinitely far out of its picture.
#[test]
fn teleporting_camera() {
    let (errors, _) = Case::new(
        "teleporting_camera",
        |s| still_and_moving(s, taa()),
        |world, frame| turn_camera(world, if frame == 4 { 2.5 } else { 0.0 }),
    )
    .measure();
    assert!(errors.largest_share <= 1.0, "{errors:?}");
}

#[test]
fn teleporting_meshes() {
    Case::new(
        "teleporting_meshes",
        |s| still_and_moving(s, taa()),
        |world, frame| {
            if frame == 4 {
                shift_movers(world, Vec3::new(-1.5, 0.8, -2.0));
            }
        },
    )
    .compare();
}

#[test]
fn viewport() {
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
}

#[test]
fn orthographic() {
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
    // The background moves by hundreds of pixels there, in forward too.
    assert!(errors.largest <= LARGEST && errors.rms <= RMS, "{errors:?}");
}

/// A wall that hides the scene but for the movers' way goes and comes, and the camera cuts to behind it.
fn uncover(world: &mut World, frame: usize) {
    move_all(world, frame);
    let hides = matches!(frame, 0..3 | 5..8 | 11..14);
    let mut walls = world.query_filtered::<&mut Transform, With<Wall>>();
    walls.single_mut(world).expect("one wall").translation.y = if hides { 0.0 } else { -30.0 };
    if frame == 9 {
        turn_camera(world, 2.5);
    }
}

#[derive(Component)]
struct Wall;

fn hidden_scene(s: &mut SceneBuilder, camera: impl Bundle) {
    still_and_moving(s, camera);
    for i in 0..12 {
        let ball = s.mesh(
            Sphere::new(0.25),
            StandardMaterial {
                opaque_render_method: if i % 3 == 0 {
                    OpaqueRendererMethod::Forward
                } else {
                    OpaqueRendererMethod::Auto
                },
                ..Color::srgb(0.5, 0.6, 0.2).into()
            },
            Transform::from_xyz(i as f32 * 0.4 - 2.2, 0.6, 1.4 + (i % 4) as f32 * 0.2),
        );
        if i % 2 == 0 {
            s.world().entity_mut(ball).insert(Mover);
        }
    }
    let wall = s.mesh(
        Cuboid::new(7.0, 3.0, 0.1),
        Color::srgb(0.6, 0.6, 0.6),
        Transform::from_xyz(0.0, 0.0, 2.8),
    );
    s.world().entity_mut(wall).insert(Wall);
}

#[test]
fn occlusion_culling() {
    let case = Case::new(
        "occlusion_culling",
        |s| hidden_scene(s, (taa(), OcclusionCulling)),
        uncover,
    );
    let (errors, _) = Case { frames: 16, ..case }.measure();
    assert!(errors.largest_share <= 1.0, "{errors:?}");
}

/// Then Bevy's prepass draws all meshes.
#[test]
fn what_only_the_prepass_can_do_is_left_to_it() {
    let case = Case::new(
        "normal_prepass",
        |s| still_and_moving(s, (MotionVectorPrepass, NormalPrepass)),
        move_all,
    );
    let (errors, _) = Case {
        resolves: false,
        ..case
    }
    .measure();
    assert_eq!(errors.unequal, 0, "{errors:?}");
    // Without a copy of depth the second phase of culling cannot be told from the first.
    let case = Case::new(
        "culling_without_depth",
        |s| {
            hidden_scene(s, (MotionVectorPrepass, OcclusionCulling));
            // Bevy's culling reads it, but asks for that only where there is a `DepthPrepass`.
            let mut cameras = s.world().query::<&mut Camera3d>();
            let mut camera = cameras.single_mut(s.world()).expect("one camera");
            camera.depth_texture_usages =
                (TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING).into();
        },
        uncover,
    );
    let (errors, _) = Case {
        resolves: false,
        ..case
    }
    .measure();
    assert_eq!(errors.unequal, 0, "{errors:?}");
}

/// From the first frame of the app on, while meshes load and nothing has a past.
#[test]
fn first_frames() {
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
}

type Taa = (
    TemporalAntiAliasing,
    TemporalJitter,
    MipBias,
    DepthPrepass,
    MotionVectorPrepass,
);

/// Makes frames in which all moves, and returns the view and whether it has a motion texture.
fn run(headless: &mut Headless, frames: usize) -> (Option<ActiveLeanView>, bool) {
    for frame in 0..frames {
        move_all(headless.world(), frame);
        headless.frames(1);
    }
    let view = active_view(headless);
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut textures = world.query::<&GBufferTextures>();
    let has_texture =
        (textures.iter(world)).any(|textures| textures.optional(GBufferTargets::MOTION).is_some());
    (view, has_texture)
}

#[test]
fn targets_come_and_go() {
    let mut headless = build(SIZE, |s| still_and_moving(s, ()));
    set_lean(&mut headless, true);
    headless.settle();
    let world = headless.world();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let camera = cameras.single(world).expect("one camera");
    for _ in 0..2 {
        let (view, has_texture) = run(&mut headless, 6);
        let view = view.expect("lean");
        assert!(!view.resolves_motion && !has_texture, "{view:?}");
        assert!(view.targets == GBufferTargets::EMISSIVE, "{view:?}");

        headless.world().entity_mut(camera).insert(taa());
        let (view, has_texture) = run(&mut headless, 6);
        assert!(view.expect("lean").resolves_motion && has_texture);

        headless.world().entity_mut(camera).remove::<Taa>();
    }

    // What has stopped keeps its target for a while, not for ever.
    headless.world().entity_mut(camera).insert(taa());
    assert!(run(&mut headless, 6).1);
    headless.frames(20);
    assert!(run(&mut headless, 0).1);
    headless.frames(180);
    let (view, has_texture) = run(&mut headless, 0);
    assert!(view.expect("lean").resolves_motion && !has_texture);

    set_lean(&mut headless, false);
    assert!(run(&mut headless, 3).0.is_none());
    log_watch::assert_validation_layer_silent();
}

/// What moves is coloured, what rests black.
#[test]
fn the_motion_target_can_be_shown() {
    let mut headless = build(SIZE, |s| {
        still_and_moving(s, MotionVectorPrepass);
    });
    set_lean(&mut headless, true);
    let world = headless.world();
    let mut cameras = world.query::<(&mut LeanDeferred, &mut Tonemapping)>();
    let (mut lean, mut tonemapping) = cameras.single_mut(world).expect("one camera");
    lean.debug_view = Some(GBufferChannel::Motion);
    *tonemapping = Tonemapping::None;
    headless.settle();
    let film = headless.film(6, |world, _| {
        shift_movers(world, Vec3::new(0.06, 0.03, 0.0));
    });
    if let Some(folder) = std::env::var_os("PARITY_PICTURES") {
        film[5].save(std::path::Path::new(&folder).join("motion_channel.png"));
    }
    // To the right and up: red above the middle, green below it, blue in the middle.
    let is_mover = |p: &[u8]| p[0] > 190 && p[1] < 185 && p[2].abs_diff(188) < 3;
    let is_still = |p: &[u8]| p[..3] == [0; 3];
    let count = |is: &dyn Fn(&[u8]) -> bool| film[5].rgba.chunks(4).filter(|p| is(p)).count();
    assert!(count(&is_mover) > 200, "{}", count(&is_mover));
    assert!(count(&is_still) > 10_000, "{}", count(&is_still));
}

/// How often a mesh was sorted anew in `frames` frames, in which `moves` says whether the movers move. Bevy is not to queue
/// any again.
fn resorts(headless: &mut Headless, frames: usize, moves: impl Fn(usize) -> bool) -> usize {
    let mut count = 0;
    for frame in 0..frames {
        if moves(frame) {
            // To and fro, within sight.
            let side = if frame % 2 == 0 { 0.1 } else { -0.1 };
            shift_movers(headless.world(), Vec3::X * side);
        }
        headless.frames(1);
        let world = headless.app.sub_app(RenderApp).world();
        let asked_of_bevy = &world.resource::<DirtySpecializations>().changed_renderables;
        assert!(asked_of_bevy.is_empty(), "{asked_of_bevy:?}");
        count += world.resource::<SortedMeshes>().0;
    }
    count
}

/// A mesh is sorted anew when it starts to move and when it has stopped, not while it moves or halts; and for the first
/// time once more when the view has the target.
#[test]
fn moving_meshes_are_sorted_once() {
    let mut headless = build(SIZE, |s| still_and_moving(s, taa()));
    set_lean(&mut headless, true);
    headless.settle();
    assert_eq!(resorts(&mut headless, 4, |_| false), 0);
    let first = resorts(&mut headless, 50, |_| true);
    assert!(
        (4..=12).contains(&first),
        "two movers, sorted {first} times"
    );
    assert_eq!(resorts(&mut headless, 60, |frame| frame % 8 == 7), 0);
    assert_eq!(resorts(&mut headless, 50, |_| false), 2);
    assert_eq!(resorts(&mut headless, 50, |_| true), 2);
    assert_eq!(resorts(&mut headless, 50, |_| false), 2);
    assert_eq!(resorts(&mut headless, 50, |_| false), 0);
}

/// Films a scene in which camera and meshes move.
fn pictures_of(camera: impl Bundle, lean: bool) -> Vec<Picture> {
    let mut headless = build(SIZE, |s| still_and_moving(s, camera));
    set_lean(&mut headless, lean);
    align(&mut headless, 256);
    headless.film(8, |world, frame| {
        turn_camera(world, frame as f32 * 0.03);
        shift_movers(world, Vec3::new(0.1, 0.04, -0.06));
    })
}

/// Pictures in which pixels are fetched along motion vectors: lean beside lean with Bevy's motion vectors, and beside
/// forward. In the first frame that they move, forward draws the movers: the view gets its motion target one later.
fn compare_pictures<B: Bundle>(name: &str, camera: impl Fn() -> B, least_psnr: f64) {
    let films = [
        pictures_of(camera(), false),
        pictures_of((camera(), NormalPrepass), true),
        pictures_of(camera(), true),
    ];
    assert!(films[0][6].rgba != films[0][7].rgba, "nothing moves");
    let judge_frame = |frame: usize| {
        let [forward, bevy, lean] = films.each_ref().map(|film| &film[frame]);
        [
            judge(&format!("{name}_{frame}_motion"), bevy, lean, 50.0),
            judge(&format!("{name}_{frame}"), forward, lean, least_psnr),
        ]
    };
    report((0..8).flat_map(judge_frame));
}

#[test]
fn temporal_anti_aliasing_pictures() {
    compare_pictures("taa", taa, LEAST_PSNR);
}

#[test]
fn motion_blur_pictures() {
    let blur = || {
        (
            MotionBlur {
                shutter_angle: 2.0,
                samples: 4,
            },
            DepthPrepass,
        )
    };
    compare_pictures("motion_blur", blur, LEAST_PSNR);
}
