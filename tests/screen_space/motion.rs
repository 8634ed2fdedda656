//! Light of the last frame, while things or the camera move.

use bevy::{core_pipeline::prepass::MotionVectorPrepass, mesh::skinning::SkinnedMesh, prelude::*};
use bevy_lean_deferred::prelude::*;
use kit::{
    analytic_light::{Seen, camera, errors, look, look_at_once, see, surface},
    analytic_mirrors::{compare, metal, mirror_app, show_mirror},
    headless::Headless,
    lean::{build, change_cameras, show},
    motion::{
        film::{Shown, rmse},
        paths::Path,
        yard::{Subject, Yard},
    },
    own_process::in_own_process,
    scenes::{SceneBuilder, meshes::skinned},
    skipped::on_swiftshader,
};

use super::scenes::{
    EYE, Mover, SIZE, SMALL, floor, gi, light_at, looking, move_cameras, reflections, spawn_floor,
    step, with_motion,
};

/// The frame after a cut has no light of the one before it; without the cut it has.
#[test]
fn the_frame_after_a_cut_has_no_light_of_the_one_before() {
    in_own_process(|| {
        let sums = [false, true].map(|cuts| {
            let mut headless = mirror_app(SMALL, 0.0, |camera| {
                camera.insert(reflections());
            });
            see(&mut headless, 4);
            move_cameras(&mut headless, 0.02 * Vec3::X);
            if cuts {
                change_cameras(&mut headless, |camera| {
                    camera.insert(CameraCut);
                });
            }
            let first = look_at_once(&mut headless);
            let second = look_at_once(&mut headless);
            // In front of everything that glows.
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

/// Three frames after a cut the mirror is as accurate as before.
#[test]
fn a_cut_forgets_the_last_frame() {
    in_own_process(|| {
        let mut headless = mirror_app(SIZE, 0.0, |camera| {
            camera.insert(reflections());
        });
        see(&mut headless, 4);
        change_cameras(&mut headless, |camera| {
            camera.insert(CameraCut);
        });
        headless.frames(3);
        assert!(show_mirror(&mut headless).inside.psnr() > 40.0);
    });
}

const BOX: f32 = 0.4;
/// Metres per frame.
const PACE: f32 = 0.08;
const FRAMES: usize = 12;

/// A glowing box on a floor that mirrors it or is lit by it, in front of a wall, of which it uncovers more in each frame.
fn moving_box(headless: &mut Headless, motion: bool, floor: StandardMaterial, extra: impl Bundle) {
    show(headless, |s| {
        spawn_floor(s, floor, 0.0);
        let behind = Transform::from_xyz(0.0, 0.5, -0.5);
        s.mesh(Rectangle::new(6.0, 1.0), surface(0.0, 0.0), behind);
        let place = Transform::from_xyz(-1.0, 0.25, 0.0);
        let glowing = s.mesh(Cuboid::from_length(BOX), surface(0.0, 1.0), place);
        s.world().entity_mut(glowing).insert(Mover(Vec3::X * PACE));
        let camera = camera(s, looking(EYE, 0.2), 0.0, extra);
        with_motion(motion, &mut s.world().entity_mut(camera));
    });
}

#[test]
fn there_is_no_trail_behind_what_moves() {
    in_own_process(|| check_trails(true));
}

#[test]
#[ignore = "nightly: the same without motion vectors"]
fn there_is_no_trail_without_motion_vectors() {
    in_own_process(|| check_trails(false));
}

/// Light of a moving box moves with it: its light on the floor behind it is gone after two frames.
fn check_trails(motion: bool) {
    let mut headless = Headless::new(SMALL);
    type Make<'a> = &'a dyn Fn(&mut Headless, bool);
    // With the longest trail in frames. A rough floor is also lit by the box's position at which its light was kept, and shows the mean
    // of four frames, which weigh less if motion vectors tell that the box moves. On a diffuse floor the means of blocks are continued to
    // the edge of the box, of blocks whose light is partly unknown while it moves.
    let of_rough = if motion { 3.5 } else { 5.2 };
    let make: [(&str, f32, Make); 3] = [
        ("mirror", 0.5, &|headless, motion| {
            moving_box(headless, motion, metal(0.0), reflections());
        }),
        ("rough", of_rough, &|headless, motion| {
            moving_box(headless, motion, metal(0.3), reflections());
        }),
        ("diffuse", 2.0, &|headless, motion| {
            moving_box(headless, motion, surface(0.5, 0.0), gi());
        }),
    ];
    for (name, longest, make) in make {
        make(&mut headless, motion);
        see(&mut headless, 8);
        let moving = step(&mut headless, FRAMES);
        moving.save(&format!("trail_{name}_{motion}"), 1.0);
        headless.frames(12);
        let still = look(&mut headless);
        still.save(&format!("trail_{name}_{motion}_still"), 1.0);
        // The furthest distance behind the box, in frames of its motion, at which the floor is brighter than with the box at rest.
        let right = -1.0 + FRAMES as f32 * PACE - BOX / 2.0;
        let brighter = floor(&moving)
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
        println!("{name}, motion vectors {motion}: {trail:.1} frames behind, brightest {most:.2}");
        assert!(trail <= longest);
    }
}

#[test]
fn moving_mirrors_show_what_they_show_at_rest() {
    in_own_process(|| check_moving_mirrors(true));
}

#[test]
#[ignore = "nightly: the same without motion vectors"]
fn moving_mirrors_show_what_they_show_at_rest_without_motion_vectors() {
    in_own_process(|| check_moving_mirrors(false));
}

/// A mirror that moves, or whose mesh deforms, shows the same as one at rest.
fn check_moving_mirrors(motion: bool) {
    let mut headless = Headless::new(SMALL);
    const UP: Mover = Mover(Vec3::new(0.0, 0.02, 0.0));
    let moves_up = |s: &mut SceneBuilder| {
        let mirror = spawn_floor(s, metal(0.0), -0.3);
        s.world().entity_mut(mirror).insert(UP);
    };
    let bends = |s: &mut SceneBuilder| {
        let joint = skinned(s);
        s.world().entity_mut(joint).insert(UP);
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
        show(&mut headless, |s| {
            mirror(s);
            let wall = Rectangle::new(3.0, 1.0);
            s.mesh(wall, surface(0.0, 1.0), Transform::from_xyz(0.0, 0.6, -0.8));
            let camera = camera(s, looking(EYE, 0.2), 0.3, reflections());
            with_motion(motion, &mut s.world().entity_mut(camera));
        });
        see(&mut headless, 8);
        let moving = step(&mut headless, 8);
        moving.save(&format!("mover_{name}_{motion}"), 0.8);
        headless.frames(12);
        let still = look(&mut headless);
        still.save(&format!("mover_{name}_{motion}_still"), 0.8);
        let pairs = moving.light.texels.iter().zip(&still.light.texels);
        let (off, bias) = errors(pairs.map(|(moving, still)| moving[1] - still[1]));
        println!("{name}, motion vectors {motion}: {off:.4} ({bias:+.4}) of the wall's light");
        assert!(off < 0.002);
    }
}

/// The last of twelve frames of a camera that takes these poses, and the same pose at rest.
fn moving_and_still(
    headless: &mut Headless,
    name: &str,
    pose: impl Fn(usize) -> Transform,
) -> [Seen; 2] {
    let mut moving = see(headless, 8);
    for frame in 1..=12 {
        change_cameras(headless, |camera| {
            camera.insert(pose(frame));
        });
        moving = look_at_once(headless);
    }
    headless.frames(8);
    let still = look(headless);
    moving.save(&format!("{name}_moving"), 1.0);
    still.save(&format!("{name}_still"), 1.0);
    [moving, still]
}

/// `moving_and_still` of a camera that strafes by `step` metres a frame, past glowing pillars, `width` metres wide and at this `z`, on a
/// metal floor.
fn strafe_past_pillars(name: &str, step: f32, roughness: f32, width: f32, z: f32) -> [Seen; 2] {
    let pose = |frame: usize| looking(EYE + Vec3::X * (step * (frame as f32 - 12.0)), 0.3);
    let mut headless = build(SIZE, |s| {
        spawn_floor(s, metal(roughness), 0.0);
        for x in [-1.2, -0.4, 0.4, 1.2] {
            let pillar = Cuboid::new(width, 1.4, 0.12);
            s.mesh(pillar, surface(0.0, 1.0), Transform::from_xyz(x, 0.7, z));
        }
        camera(s, pose(0), 0.0, reflections());
    });
    moving_and_still(&mut headless, name, pose)
}

/// Lobes of the last frames are where the mirror image was, and are interpolated: under a camera that strafes at 3 m/s, images of
/// pillars in a rough floor do not lag, and have no seams across them.
#[test]
fn rough_mirror_images_follow_a_strafing_camera() {
    in_own_process(|| {
        let [moving, still] = strafe_past_pillars("strafe", 0.05, 0.3, 0.12, -1.0);
        let size = moving.light.size;
        let off = |x: u32, y: u32| {
            let at = (x + y * size.x) as usize;
            moving.light.texels[at][1] - still.light.texels[at][1]
        };
        let rows = size.y * 5 / 8..size.y - 1;
        let (lag, _) = errors(
            rows.clone()
                .flat_map(|y| (0..size.x).map(move |x| off(x, y))),
        );
        // A seam is a step of the difference along a whole row.
        let seam = rows
            .map(|y| errors((0..size.x).map(|x| off(x, y + 1) - off(x, y))).0)
            .fold(0.0, f32::max);
        println!("lag {lag:.4}, largest seam {seam:.4} of the pillars' light");
        assert!(lag < 0.016 && seam < 0.0035);
    });
}

/// Lobes of the last frames leave no streaks where all rays of this frame miss: beside the images of pillars in a glossy floor, under a
/// camera that strafes at 6 m/s.
#[test]
fn images_in_glossy_floors_leave_no_streaks() {
    in_own_process(|| {
        let [moving, still] = strafe_past_pillars("streaks", 0.1, 0.12, 0.3, -0.5);
        let size = moving.light.size;
        let is_dark = |x: u32, y: u32| {
            let near = (x.saturating_sub(6)..(x + 7).min(size.x))
                .map(|x| still.light.texels[(x + y * size.x) as usize][1]);
            near.fold(0.0, f32::max) < 0.02
        };
        let mut streaks = 0;
        for y in size.y * 5 / 8..size.y - 1 {
            for x in (0..size.x).filter(|x| is_dark(*x, y)) {
                streaks += u32::from(moving.light.texels[(x + y * size.x) as usize][1] > 0.05);
            }
        }
        println!("{streaks} pixels of streaks");
        assert!(streaks < 30);
    });
}

/// Coarse levels of the last frame have outlines where this frame has them: in mirrors of the yard, the tenth frame of the strafing camera
/// is nearly as at rest (0.0076 off with the outlines of the last frame).
#[test]
fn outlines_in_mirrors_follow_a_strafing_camera() {
    in_own_process(|| {
        let size = UVec2::new(640, 360);
        let mut yard = Yard::new(size, Subject::Reflections, |camera| {
            camera.insert((MotionVectorPrepass, reflections()));
        });
        let pose = |frame| Path::Strafe.pose(frame, 48);
        yard.rest(&pose(0), 8);
        let mut moving = None;
        for frame in 1..=10 {
            yard.pose(&pose(frame));
            moving = Some(Shown::of(&yard.frame()));
        }
        let [_, still] = yard.rest(&pose(10), 8);
        let off = rmse(&moving.expect("ten frames"), &Shown::of(&still));
        println!("off by {off:.4}");
        assert!(off < 0.0069);
    });
}

/// A rough metal that the camera carries shows what it shows at rest, while the camera turns by 100° a second: its mirror images
/// stream over it, and are not those of four frames.
#[test]
fn rough_metals_that_a_turning_camera_carries_do_not_lag() {
    in_own_process(|| {
        let pose = |frame: usize| {
            let turned = Quat::from_rotation_y(0.18 - 0.03 * frame as f32);
            Transform::from_xyz(0.0, 1.2, 3.0).with_rotation(turned)
        };
        let mut headless = build(SIZE, |s| {
            for x in [-1.8, -1.2, -0.6, 0.0, 0.6, 1.2, 1.8] {
                let pillar = Cuboid::new(0.2, 3.0, 0.2);
                s.mesh(pillar, surface(0.0, 1.0), Transform::from_xyz(x, 1.2, -1.0));
            }
            let place = Transform::from_xyz(0.15, -0.12, -0.5);
            let weapon = s.mesh(Cuboid::new(0.08, 0.08, 0.5), metal(0.3), place);
            let camera = camera(s, pose(0), 0.0, reflections());
            with_motion(true, &mut s.world().entity_mut(camera));
            s.world().entity_mut(weapon).insert(ChildOf(camera));
        });
        let [moving, still] = moving_and_still(&mut headless, "carried_metal", pose);
        // Nothing else reflects.
        let pairs = moving.light.texels.iter().zip(&still.light.texels);
        let (lag, bias) = errors(pairs.map(|(moving, still)| moving[1] - still[1]));
        println!("lag {lag:.4} ({bias:+.4}) of the pillars' light");
        // 0.019; with lobes that were fetched as on a mirror at rest 0.025.
        assert!(lag < 0.022);
    });
}

/// On a floor between glowing pillars, light stays in place while the camera pans back and forth for 60 frames without TAA.
#[test]
#[ignore = "nightly: 80 frames of what mirrors show"]
fn light_stays_where_it_is_while_the_camera_pans() {
    in_own_process(|| {
        let pose = |frame: usize| {
            let angle = 0.12 * (frame as f32 * 0.1).sin();
            let from = Vec3::new(3.0 * angle.sin(), 1.2, 3.0 * angle.cos());
            looking(from, 0.4)
        };
        let mut headless = build(SIZE, |s| {
            spawn_floor(s, surface(0.5, 0.0), 0.0);
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
            // Light of the floor at each position of the last frame.
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

#[test]
fn mirror_images_stay_where_they_are_while_the_camera_pans() {
    in_own_process(|| {
        let most = on_swiftshader(0.0055, 0.004, "a smooth mirror under a camera that pans");
        check_panning([(0.0, LeanQuality::Medium, [most, 0.006])]);
    });
}

#[test]
#[ignore = "nightly: rough floors of each quality"]
fn rough_mirror_images_stay_where_they_are_while_the_camera_pans() {
    in_own_process(|| {
        let qualities = [LeanQuality::Low, LeanQuality::Medium, LeanQuality::High];
        check_panning(qualities.map(|quality| (0.3, quality, [0.012, 0.007])));
    });
}

/// A patterned wall is reflected in a metal floor, and the camera pans back and forth: the light at each position of the mirror image is
/// constant from frame to frame, and equals that of the camera at rest. Takes floors: roughness, quality, and largest errors.
fn check_panning(floors: impl IntoIterator<Item = (f32, LeanQuality, [f32; 2])>) {
    let pose = |frame: usize| {
        let angle = 0.12 * (frame as f32 * 0.1).sin();
        let from = Vec3::new(3.2 * angle.sin(), 1.1, 3.2 * angle.cos());
        looking(from, 0.35)
    };
    // Positions on the wall's mirror image that neither the ball nor the box covers.
    let places: Vec<Vec3> = (0..24 * 24)
        .map(|i| Vec2::new((i % 24) as f32, (i / 24) as f32) / 24.0)
        .map(|at| Vec3::new(0.7 * at.x - 0.25, -(0.15 + 1.2 * at.y), -1.5))
        .collect();
    let light = |headless: &mut Headless, seen: &Seen| -> Vec<Option<f32>> {
        let places = places.iter();
        places
            .map(|place| light_at(headless, seen, *place))
            .collect()
    };
    type Lights = Vec<Option<f32>>;
    let less = |some: &Lights, other: &Lights| -> Vec<f32> {
        let pairs = some.iter().zip(other);
        pairs
            .filter_map(|(some, other)| Some((*some)? - (*other)?))
            .collect()
    };
    let mut headless = mirror_app(SMALL, 0.0, |_| ());
    for (roughness, quality, most) in floors {
        let mut materials = headless.world().resource_mut::<Assets<StandardMaterial>>();
        for (_, material) in materials.iter_mut() {
            if material.metallic > 0.0 {
                material.perceptual_roughness = roughness;
            }
        }
        change_cameras(&mut headless, |camera| {
            let effect = LeanScreenSpaceReflections {
                quality,
                ..reflections()
            };
            camera.insert((effect, pose(0), CameraCut));
        });
        let first = see(&mut headless, 8);
        let mut before = light(&mut headless, &first);
        let [mut differences, mut lags] = [Vec::new(), Vec::new()];
        for frame in 1..=60 {
            change_cameras(&mut headless, |camera| {
                camera.insert(pose(frame));
            });
            let moving = look_at_once(&mut headless);
            let moving = light(&mut headless, &moving);
            differences.extend(less(&moving, &before));
            before = moving;
            // The camera rests now and then.
            if frame % 10 == 0 {
                headless.frames(4);
                let still = look(&mut headless);
                let still = light(&mut headless, &still);
                lags.extend(less(&before, &still));
                before = still;
            }
        }
        let places = differences.len();
        let (from_frame_to_frame, _) = errors(differences);
        let (lag, bias) = errors(lags);
        println!(
            "roughness {roughness}, {quality:?}: from frame to frame {from_frame_to_frame:.4}, to the camera at rest {lag:.4} ({bias:+.4}); {places} places",
        );
        assert!(places > 60 * 200);
        assert!(from_frame_to_frame < most[0] && lag < most[1] && bias.abs() < 1e-3);
    }
}

/// True on the floor in front of the pillars, of which they hide nothing.
fn is_before_pillars(place: Vec3) -> bool {
    let front = 0.3 * place.x - 0.1;
    place.x.abs() < 1.2 && place.z > front && place.z < front + 0.4
}

/// Steps of a camera that moves sideways.
#[derive(Resource)]
struct Pace(Vec3);

fn walk(pace: Res<Pace>, mut cameras: Query<&mut Transform, With<Camera3d>>) {
    for mut camera in &mut cameras {
        camera.translation += pace.0;
    }
}

fn walking(headless: &mut Headless, pace: Vec3) {
    headless.app.insert_resource(Pace(pace));
    headless.app.add_systems(Update, walk);
}

#[test]
fn mirrors_keep_up_with_cameras() {
    in_own_process(|| check_mirrors_of_walkers(true));
}

#[test]
#[ignore = "nightly: the same without motion vectors"]
fn mirrors_keep_up_with_cameras_without_motion_vectors() {
    in_own_process(|| check_mirrors_of_walkers(false));
}

fn check_mirrors_of_walkers(motion: bool) {
    let mut headless = mirror_app(SIZE, 0.0, |camera| {
        camera.insert(reflections());
        with_motion(motion, camera);
    });
    see(&mut headless, 4);
    walking(&mut headless, Vec3::new(0.01, 0.003, -0.005));
    headless.frames(10);
    let seen = look(&mut headless);
    let found = compare(&mut headless, seen);
    found.seen.save(&format!("walking_{motion}"), 1.0);
    println!(
        "motion vectors {motion}: {:.1} dB, without outlines {:.1} dB",
        found.everywhere.psnr(),
        found.inside.psnr()
    );
    assert!(found.inside.psnr() > 36.0);
}
