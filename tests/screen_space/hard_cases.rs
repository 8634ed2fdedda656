//! Reflections and GI where they are hard: other projections, thin things, what moves, cuts, several cameras.

use bevy::{
    camera::{ScalingMode, SubCameraView, Viewport},
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    material::OpaqueRendererMethod,
    math::bounding::{Aabb3d, RayCast3d},
    mesh::skinning::SkinnedMesh,
    prelude::*,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    headless::Headless,
    known_light::{Seen, camera, errors, look, look_at_once, see, show, surface},
    known_mirrors::{metal, mirror, mirror_app},
    lean::{build, change_cameras},
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::{SceneBuilder, meshes::skinned},
};

const SIZE: UVec2 = UVec2::new(480, 360);
const SMALL: UVec2 = UVec2::new(192, 144);

fn reflections() -> LeanScreenSpaceReflections {
    LeanScreenSpaceReflections {
        edge_fade: 0.0,
        ..default()
    }
}

/// Further than anything in these scenes.
fn gi() -> LeanScreenSpaceGi {
    LeanScreenSpaceGi {
        radius: 100.0,
        falloff: 0.1,
        ..default()
    }
}

#[test]
fn mirrors_are_exact_in_any_projection() {
    in_own_process(|| {
        let orthographic = |camera: &mut EntityWorldMut| {
            camera.insert(Projection::Orthographic(OrthographicProjection {
                scaling_mode: ScalingMode::FixedVertical {
                    viewport_height: 2.6,
                },
                ..OrthographicProjection::default_3d()
            }));
        };
        // The upper left of a larger picture.
        let off_center = |camera: &mut EntityWorldMut| {
            let mut camera = camera.get_mut::<Camera>().expect("it is one");
            camera.sub_camera_view = Some(SubCameraView {
                full_size: SIZE * 3 / 2,
                offset: Vec2::new(40.0, 70.0),
                size: SIZE,
            });
        };
        let grazing = |camera: &mut EntityWorldMut| {
            let from = Transform::from_xyz(0.0, 0.35, 3.2);
            camera.insert(from.looking_at(Vec3::new(0.0, 0.3, 0.0), Vec3::Y));
        };
        type Dress<'a> = &'a dyn Fn(&mut EntityWorldMut);
        let cases: [(&str, Dress, f32); 3] = [
            ("orthographic", &orthographic, 36.0),
            ("off-centre", &off_center, 36.0),
            ("grazing", &grazing, 30.0),
        ];
        for (name, dress, least) in cases {
            let found = mirror(SIZE, |camera| {
                camera.insert(reflections());
                dress(camera);
            });
            found.seen.save(&format!("mirror_{name}"), 1.0);
            println!(
                "{name}: {:.1} dB, without outlines {:.1} dB, {:.2} in the picture",
                found.everywhere.psnr(),
                found.inside.psnr(),
                found.share
            );
            assert!(found.share > 0.5 && found.inside.psnr() > least);
        }
    });
}

/// Where the ray that is mirrored at `place` on the floor goes.
fn mirrored(eye: Vec3, place: Vec3) -> Option<Ray3d> {
    let direction = (place - eye) * Vec3::new(1.0, -1.0, 1.0);
    Some(Ray3d::new(place, Dir3::new(direction).ok()?))
}

/// A thin pole hides what is behind it in the mirror, and nothing beside it: nobody knows how thick it is.
#[test]
fn a_thin_pole_hides_no_more_than_itself() {
    in_own_process(|| {
        const POLE: Vec3 = Vec3::new(0.015, 0.5, 0.015);
        let eye = Vec3::new(0.0, 1.0, 3.0);
        let (mut headless, seen) = show(SIZE, 6, |s| {
            let wall = Rectangle::new(6.0, 3.0);
            s.mesh(wall, surface(0.0, 1.0), Transform::from_xyz(0.0, 1.5, -4.0));
            let pole = Cuboid::from_size(2.0 * POLE);
            s.mesh(
                pole,
                surface(0.0, 0.0),
                Transform::from_xyz(0.0, POLE.y, 0.0),
            );
            let floor = Plane3d::default().mesh().size(12.0, 12.0);
            s.mesh(floor, metal(0.0), Transform::default());
            let from = Transform::from_translation(eye);
            let from = from.looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y);
            camera(s, from, 0.0, reflections());
        });
        seen.save("pole", 1.0);
        // What the mirror shows beside what stands there, in pixels.
        let bounds = Aabb3d::new(Vec3::new(0.0, POLE.y, 0.0), POLE);
        let (mut dark, mut hidden) = (0, 0);
        for (_, place, light) in seen.on_plane(Vec3::ZERO, Vec3::Y) {
            // The pole itself, and what is beyond it.
            let Some(ray) = mirrored(eye, place).filter(|_| place.z > POLE.z) else {
                continue;
            };
            let meets_wall = (-4.0 - place.z) / ray.direction.z;
            let at = ray.get_point(meets_wall);
            let is_on_wall = at.y > 0.1 && at.y < 2.9 && at.x.abs() < 2.8;
            if !is_on_wall || light_at(&mut headless, &seen, at).is_none() {
                continue;
            }
            hidden += i32::from(
                RayCast3d::from_ray(ray, 100.0)
                    .aabb_intersection_at(&bounds)
                    .is_some(),
            );
            dark += i32::from(light < 0.5);
        }
        println!("{hidden} pixels mirror the pole, {dark} are dark");
        assert!(hidden > 100 && (dark - hidden).abs() < hidden / 4);
    });
}

/// All of what stands above a mirror is in it, up to its edge.
#[test]
fn mirrored_edges_have_no_gaps() {
    in_own_process(|| {
        const WALL_Z: f32 = -0.8;
        const FLOOR: Vec3 = Vec3::new(0.0, -0.14, 0.0);
        let eye = Vec3::new(0.0, 1.2, 3.0);
        let (_, seen) = show(SMALL, 8, |s| {
            let plane = Plane3d::default().mesh().size(12.0, 12.0);
            s.mesh(plane, metal(0.0), Transform::from_translation(FLOOR));
            let wall = Rectangle::new(3.0, 1.0);
            s.mesh(
                wall,
                surface(0.0, 1.0),
                Transform::from_xyz(0.0, 0.6, WALL_Z),
            );
            let from = Transform::from_translation(eye).looking_at(Vec3::Y * 0.2, Vec3::Y);
            camera(s, from, 0.3, reflections());
        });
        seen.save("edge", 0.8);
        let (mut dark, mut count) = (0, 0);
        for (_, place, light) in seen.on_plane(FLOOR, Vec3::Y) {
            let direction = (place - eye) * Vec3::new(1.0, -1.0, 1.0);
            let met = place + direction * (WALL_Z - place.z) / direction.z;
            if place.z > WALL_Z && met.x.abs() < 1.3 && met.y > 0.11 && met.y < 1.0 {
                dark += i32::from(light < 0.8);
                count += 1;
            }
        }
        println!("{dark} of {count} pixels are dark");
        assert!(count > 1000 && dark < 4);
    });
}

/// What the floor shows at each pixel, where it is floor.
fn floor(seen: &Seen) -> impl Iterator<Item = (Vec3, f32)> {
    let places = seen.on_plane(Vec3::ZERO, Vec3::Y);
    places.map(|(_, place, light)| (place, light))
}

/// The frame after a cut has no light of the one before it; without the cut it has.
#[test]
fn the_frame_after_a_cut_has_no_light_of_the_one_before() {
    in_own_process(|| {
        let sums = [false, true].map(|cuts| {
            let mut headless = mirror_app(SMALL, 0.0, |camera| {
                camera.insert(reflections());
            });
            see(&mut headless, 4);
            change_cameras(&mut headless, |camera| {
                let mut transform = camera.get_mut::<Transform>().expect("cameras have one");
                transform.translation.x += 0.02;
                if cuts {
                    camera.insert(CameraCut);
                }
            });
            let first = look_at_once(&mut headless);
            let second = look_at_once(&mut headless);
            // In front of all that glows.
            [first, second].map(|seen| {
                let near = floor(&seen).filter(|(place, _)| place.z > 0.6);
                near.map(|(_, light)| light).sum::<f32>()
            })
        });
        let [[without, _], [with, next]] = sums;
        println!("{without:.1}; with a cut {with:.3}, then {next:.1}");
        assert!(without > 50.0 && with < 1e-3 * without && next > 0.9 * without);
    });
}

const BOX: f32 = 0.4;
/// Metres a frame.
const PACE: f32 = 0.08;

#[derive(Component)]
struct Mover;

/// A glowing box before a floor, which mirrors it or is lit by it.
fn moving_box(motion: bool, floor: StandardMaterial, extra: impl Bundle) -> Headless {
    build(SMALL, |s| {
        let plane = Plane3d::default().mesh().size(12.0, 12.0);
        s.mesh(plane, floor, Transform::default());
        let glowing = s.mesh(
            Cuboid::from_length(BOX),
            surface(0.0, 1.0),
            Transform::from_xyz(-1.0, 0.25, 0.0),
        );
        s.world().entity_mut(glowing).insert(Mover);
        let from = Transform::from_xyz(0.0, 1.2, 3.0);
        let from = from.looking_at(Vec3::new(0.0, 0.2, 0.0), Vec3::Y);
        let camera = camera(s, from, 0.0, extra);
        if motion {
            let mut camera = s.world().entity_mut(camera);
            camera.insert((DepthPrepass, MotionVectorPrepass));
        }
    })
}

fn step(headless: &mut Headless) {
    let world = headless.world();
    let mut movers = world.query_filtered::<&mut Transform, With<Mover>>();
    for mut mover in movers.iter_mut(world) {
        mover.translation.x += PACE;
    }
}

/// What a box sends goes with it: what it leaves behind on the floor is gone after four frames.
#[test]
fn there_is_no_trail_behind_what_moves() {
    in_own_process(|| {
        let dull = || surface(0.5, 0.0);
        let make: [(&str, Box<dyn Fn(bool) -> Headless>); 3] = [
            (
                "mirror",
                Box::new(|motion| moving_box(motion, metal(0.0), reflections())),
            ),
            (
                "rough",
                Box::new(|motion| moving_box(motion, metal(0.3), reflections())),
            ),
            (
                "diffuse",
                Box::new(move |motion| moving_box(motion, dull(), gi())),
            ),
        ];
        for (name, make) in make {
            for motion in [false, true] {
                let mut headless = make(motion);
                see(&mut headless, 8);
                let mut seen = None;
                for _ in 0..12 {
                    step(&mut headless);
                    seen = Some(look_at_once(&mut headless));
                }
                let moving = seen.expect("frames were seen");
                moving.save(&format!("trail_{name}_{motion}"), 1.0);
                headless.frames(24);
                let still = look(&mut headless);
                still.save(&format!("trail_{name}_{motion}_still"), 1.0);
                // The furthest back from the box, in frames of its way, where it is brighter than with the box at rest.
                let right = -1.0 + 12.0 * PACE - BOX / 2.0;
                let brighter =
                    floor(&moving)
                        .zip(floor(&still))
                        .map(|((place, moving), (_, still))| {
                            let behind = (right - place.x) / PACE;
                            (place, behind, moving - still)
                        });
                let most = still.light.texels.iter().map(|texel| texel[1]);
                let most = most.filter(|light| *light < 0.99).fold(0.0, f32::max);
                let trail = brighter
                    .filter(|(place, _, more)| place.z > 0.2 && *more > 0.03 * most)
                    .map(|(_, behind, _)| behind)
                    .fold(0.0, f32::max);
                println!(
                    "{name}, motion vectors {motion}: {trail:.1} frames behind, brightest {most:.2}"
                );
                assert!(trail <= 4.0);
            }
        }
    });
}

/// A mirror that moves, or whose mesh does, shows what one at rest shows.
#[test]
fn moving_mirrors_show_what_they_show_at_rest() {
    in_own_process(|| {
        let moves_up = |s: &mut SceneBuilder| {
            let plane = Plane3d::default().mesh().size(12.0, 12.0);
            let mirror = s.mesh(plane, metal(0.0), Transform::from_xyz(0.0, -0.3, 0.0));
            s.world().entity_mut(mirror).insert(Mover);
        };
        let bends = |s: &mut SceneBuilder| {
            let joint = skinned(s);
            s.world().entity_mut(joint).insert(Mover);
            let material = s.add::<StandardMaterial>(metal(0.1));
            let mut columns = s.world().query_filtered::<Entity, With<SkinnedMesh>>();
            let column = columns.single(s.world()).expect("one was spawned");
            s.world()
                .entity_mut(column)
                .insert(MeshMaterial3d(material));
        };
        type Mirror<'a> = &'a dyn Fn(&mut SceneBuilder);
        let cases: [(&str, Mirror); 2] = [("plane", &moves_up), ("skinned mesh", &bends)];
        for (name, mirror) in cases {
            for motion in [false, true] {
                let mut headless = build(SMALL, |s| {
                    mirror(s);
                    let wall = Rectangle::new(3.0, 1.0);
                    s.mesh(wall, surface(0.0, 1.0), Transform::from_xyz(0.0, 0.6, -0.8));
                    let from = Transform::from_xyz(0.0, 1.2, 3.0);
                    let from = from.looking_at(Vec3::new(0.0, 0.2, 0.0), Vec3::Y);
                    let camera = camera(s, from, 0.3, reflections());
                    if motion {
                        let mut camera = s.world().entity_mut(camera);
                        camera.insert((DepthPrepass, MotionVectorPrepass));
                    }
                });
                see(&mut headless, 8);
                let mut seen = None;
                for _ in 0..8 {
                    let world = headless.world();
                    let mut movers = world.query_filtered::<&mut Transform, With<Mover>>();
                    for mut mover in movers.iter_mut(world) {
                        mover.translation.y += 0.02;
                    }
                    seen = Some(look_at_once(&mut headless));
                }
                let moving = seen.expect("frames were seen");
                moving.save(&format!("mover_{name}_{motion}"), 0.8);
                headless.frames(12);
                let still = look(&mut headless);
                still.save(&format!("mover_{name}_{motion}_still"), 0.8);
                let pairs = moving.light.texels.iter().zip(&still.light.texels);
                let (off, bias) = errors(pairs.map(|(moving, still)| moving[1] - still[1]));
                println!(
                    "{name}, motion vectors {motion}: {off:.4} ({bias:+.4}) of the wall's light"
                );
                assert!(off < 0.02);
            }
        }
    });
}

/// A floor between glowing pillars, seen by a camera that pans to and fro for 60 frames without TAA.
#[test]
fn light_stays_where_it_is_while_the_camera_pans() {
    in_own_process(|| {
        let pose = |frame: usize| {
            let angle = 0.12 * (frame as f32 * 0.1).sin();
            let from = Vec3::new(3.0 * angle.sin(), 1.2, 3.0 * angle.cos());
            Transform::from_translation(from).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y)
        };
        let mut headless = build(SIZE, |s| {
            let floor = Plane3d::default().mesh().size(12.0, 12.0);
            s.mesh(floor, surface(0.5, 0.0), Transform::default());
            for x in [-1.0, -0.4, 0.3, 0.9] {
                let pillar = Cuboid::new(0.1, 1.0, 0.1);
                let place = Transform::from_xyz(x, 0.5, 0.3 * x - 0.2);
                s.mesh(pillar, surface(0.0, 1.0), place);
            }
            camera(s, pose(0), 0.0, gi());
        });
        let mut last = see(&mut headless, 16);
        let mut differences = Vec::new();
        for frame in 1..=60 {
            change_cameras(&mut headless, |camera| {
                camera.insert(pose(frame));
            });
            let seen = look_at_once(&mut headless);
            // The light of the floor at each place of the last frame.
            for (place, light) in floor(&last).filter(|(place, _)| is_before_pillars(*place)) {
                if let Some(now) = light_at(&mut headless, &seen, place) {
                    differences.push(now - light);
                }
            }
            last = seen;
        }
        headless.frames(16);
        let still = look(&mut headless);
        let lag: Vec<f32> = floor(&last)
            .zip(floor(&still))
            .filter(|((place, _), _)| is_before_pillars(*place))
            .map(|((_, moving), (_, still))| moving - still)
            .collect();
        let ((from_frame_to_frame, _), (lag, bias)) = (errors(differences), errors(lag));
        println!(
            "from frame to frame {from_frame_to_frame:.4}, to the camera at rest {lag:.4} ({bias:+.4}) of the pillars' light"
        );
        assert!(from_frame_to_frame < 0.005 && lag < 0.0025 && bias.abs() < 1e-3);
    });
}

/// On the floor in front of the pillars, which hide nothing of it.
fn is_before_pillars(place: Vec3) -> bool {
    let front = 0.3 * place.x - 0.1;
    place.x.abs() < 1.2 && place.z > front && place.z < front + 0.4
}

/// Between four pixels.
fn light_at(headless: &mut Headless, seen: &Seen, place: Vec3) -> Option<f32> {
    let world = headless.world();
    let mut cameras = world.query::<(&Camera, &GlobalTransform)>();
    let (camera, transform) = cameras.single(world).ok()?;
    let at = camera.world_to_viewport(transform, place).ok()? - 0.5;
    let (first, along) = (at.floor(), at.fract());
    if first.cmplt(Vec2::ZERO).any() || (first + 1.0).cmpge(seen.light.size.as_vec2()).any() {
        return None;
    }
    let pixel = |x: f32, y: f32| seen.at((first + Vec2::new(x, y)).as_uvec2());
    let row = |y| pixel(0.0, y).lerp(pixel(1.0, y), along.x);
    Some(row(0.0).lerp(row(1.0), along.y))
}

/// Things that glow on a floor, for one or two cameras.
fn two_views(s: &mut SceneBuilder) -> [Entity; 2] {
    let floor = Plane3d::default().mesh().size(12.0, 12.0);
    s.mesh(floor, metal(0.2), Transform::default());
    s.solids();
    s.sun(false);
    [(0, 0.0), (1, 1.5)].map(|(order, x)| {
        let half = SIZE / UVec2::new(2, 1);
        let shown = Camera {
            order,
            viewport: Some(Viewport {
                physical_position: UVec2::new(half.x * order as u32, 0),
                physical_size: half,
                ..default()
            }),
            ..default()
        };
        let from = Transform::from_xyz(x, 1.5, 4.0).looking_at(Vec3::Y * 0.5, Vec3::Y);
        let effects = (gi(), reflections());
        s.camera(from, (LeanDeferred::default(), shown, effects))
    })
}

/// Two cameras beside one another show what each shows alone.
#[test]
fn cameras_do_not_share_their_last_frames() {
    in_own_process(|| {
        let picture = |shown: [bool; 2]| {
            let mut headless = build(SIZE, |s| {
                let cameras = two_views(s);
                for (camera, is_active) in cameras.into_iter().zip(shown) {
                    let mut camera = s.world().entity_mut(camera);
                    camera.get_mut::<Camera>().expect("it is one").is_active = is_active;
                }
            });
            headless.settle();
            headless.frames(12);
            headless.capture()
        };
        let both = picture([true, true]);
        for (view, shown) in [[true, false], [false, true]].into_iter().enumerate() {
            let alone = picture(shown);
            let half = SIZE / UVec2::new(2, 1);
            let corner = UVec2::new(half.x * view as u32, 0);
            let rect = URect::from_corners(corner, corner + half);
            let difference = pixel_difference(&alone.crop(rect), &both.crop(rect));
            println!("view {view}: {difference}");
            assert!(difference.psnr > 60.0);
        }
    });
}

/// Meshes that forward draws shine where the camera has their depth.
#[test]
fn forward_meshes_shine_on_cameras_with_a_depth_prepass() {
    in_own_process(|| {
        let sum = |prepass: bool, forward: bool| {
            let (_, seen) = show(SMALL, 12, |s| {
                let plane = Plane3d::default().mesh().size(12.0, 12.0);
                s.mesh(plane, surface(0.5, 0.0), Transform::default());
                let glowing = StandardMaterial {
                    opaque_render_method: if forward {
                        OpaqueRendererMethod::Forward
                    } else {
                        OpaqueRendererMethod::Auto
                    },
                    ..surface(0.0, 1.0)
                };
                let wall = Rectangle::new(3.0, 1.0);
                s.mesh(wall, glowing, Transform::from_xyz(0.0, 0.5, -0.8));
                let from = Transform::from_xyz(0.0, 1.2, 3.0);
                let from = from.looking_at(Vec3::new(0.0, 0.3, 0.0), Vec3::Y);
                let camera = camera(s, from, 0.0, gi());
                if prepass {
                    s.world().entity_mut(camera).insert(DepthPrepass);
                }
            });
            seen.save(&format!("forward_shines_{prepass}_{forward}"), 4.0);
            let near = floor(&seen).filter(|(place, _)| place.z > -0.7);
            near.map(|(_, light)| light).sum::<f32>()
        };
        let lean = sum(true, false);
        let [without, with] = [false, true].map(|prepass| sum(prepass, true));
        println!("lean {lean:.1}, forward {without:.2}, with a prepass {with:.1}");
        assert!(without < 0.01 * lean && (with / lean - 1.0).abs() < 0.02);
    });
}

/// Once the components are gone, the picture is as before.
#[test]
fn nothing_is_left_when_they_go() {
    in_own_process(|| {
        let mut headless = build(SMALL, |s| {
            s.solids();
            s.sun(false);
            s.default_camera(LeanDeferred::default());
        });
        headless.settle();
        let before = headless.capture();
        change_cameras(&mut headless, |camera| {
            camera.insert((gi(), reflections()));
        });
        headless.settle();
        headless.frames(4);
        let with = headless.capture();
        change_cameras(&mut headless, |camera| {
            camera.remove::<(LeanScreenSpaceGi, LeanScreenSpaceReflections)>();
        });
        headless.settle();
        let after = headless.capture();
        assert!(before.rgba != with.rgba && before.rgba == after.rgba);
    });
}

/// Debug views show what was found, and spoil neither the next frame's light nor the picture after them.
#[test]
fn debug_views_show_what_was_found() {
    in_own_process(|| {
        let mut headless = mirror_app(SMALL, 0.0, |camera| {
            camera.insert((gi(), reflections()));
        });
        let picture = see(&mut headless, 6);
        let mut shown = |found: Option<ScreenSpaceReflectionsDebugView>,
                         light: Option<ScreenSpaceGiDebugView>| {
            change_cameras(&mut headless, |camera| {
                camera.insert(LeanScreenSpaceReflections {
                    debug_view: found,
                    ..reflections()
                });
                camera.insert(LeanScreenSpaceGi {
                    debug_view: light,
                    ..gi()
                });
            });
            headless.settle();
            headless.frames(4);
            look(&mut headless)
        };
        let near = |seen: &Seen| -> Vec<f32> {
            let near = floor(seen).filter(|(place, _)| place.z > 0.6 && place.z < 2.0);
            near.map(|(_, light)| light).collect()
        };
        let mirrored = near(&picture);
        // The floor of white metal shows all that it mirrors.
        let light = near(&shown(Some(ScreenSpaceReflectionsDebugView::Light), None));
        let (off, _) = errors(mirrored.iter().zip(&light).map(|(a, b)| a - b));
        let confidence = near(&shown(
            Some(ScreenSpaceReflectionsDebugView::Confidence),
            None,
        ));
        // Whoever mirrors light is confident, and the other way around.
        let agree = mirrored
            .iter()
            .zip(&confidence)
            .filter(|(light, confidence)| (**light > 0.05) == (**confidence > 0.5));
        let agree = agree.count() as f32 / mirrored.len() as f32;
        let hits = near(&shown(Some(ScreenSpaceReflectionsDebugView::Hit), None));
        // About three metres from the camera by way of the mirror.
        let hit = mirrored
            .iter()
            .zip(&hits)
            .filter(|(light, _)| **light > 0.3);
        let hit: Vec<f32> = hit.map(|(_, hit)| 1.0 / hit.max(1e-3) - 1.0).collect();
        let nearer = hit
            .iter()
            .filter(|metres| **metres > 2.0 && **metres < 7.0)
            .count();
        let open = near(&shown(None, Some(ScreenSpaceGiDebugView::Visibility)));
        let sent = near(&shown(None, Some(ScreenSpaceGiDebugView::Light)));
        let brightest = |of: &[f32]| of.iter().copied().fold(0.0, f32::max);
        println!(
            "light off by {off:.4}; {agree:.3} agree on confidence; {nearer} of {} hits",
            hit.len()
        );
        println!(
            "visible at most {:.3}, sent at most {:.3}",
            brightest(&open),
            brightest(&sent)
        );
        assert!(off < 0.05 && agree > 0.95 && nearer * 10 > hit.len() * 9);
        assert!(brightest(&open) > 0.5 && brightest(&open) <= 1.0 && brightest(&sent) > 0.01);
        let again = shown(None, None);
        let (off, _) = errors(mirrored.iter().zip(&near(&again)).map(|(a, b)| a - b));
        assert!(off < 1e-3, "the picture is off by {off}");
    });
}
