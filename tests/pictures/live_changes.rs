//! Components of meshes that an app changes by commands in `Update` while frames run: the frame of the change shows them, as in Bevy's
//! forward renderer, and nothing is drawn with data of the previous frame. In processes of their own, because no error may be logged.

use bevy::{
    camera::visibility::RenderLayers, ecs::entity_disabling::Disabled, light::NotShadowReceiver,
    pbr::Lightmap, prelude::*, render::render_resource::TextureFormat,
};
use bevy_lean_deferred::LeanDeferred;
use kit::{
    headless::{Headless, Picture},
    lean::{active_lean_views, build, set_lean},
    log_watch,
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::{SceneBuilder, build::default_camera_transform},
};

const SIZE: UVec2 = UVec2::new(160, 120);
/// Frames before the change, and frames in all.
const BEFORE: usize = 3;
const FRAMES: usize = 9;

/// A change that the app makes to a mesh.
type Change = fn(&mut EntityCommands, &Lamps);

#[derive(Resource, Clone)]
struct Lamps {
    lightmap: Handle<Image>,
}

#[derive(Resource)]
struct Subject(Entity);

/// The change to make in this frame's `Update`.
#[derive(Resource, Default)]
struct Next(Option<Change>);

fn act(mut commands: Commands, subject: Res<Subject>, lamps: Res<Lamps>, mut next: ResMut<Next>) {
    if let Some(change) = next.0.take() {
        change(&mut commands.entity(subject.0), &lamps);
    }
}

/// A floor in the shadow of a wall, under a sun.
fn scene(s: &mut SceneBuilder) {
    let mut floor = Mesh::from(Plane3d::default().mesh().size(12.0, 12.0));
    if let Some(uvs) = floor.attribute(Mesh::ATTRIBUTE_UV_0).cloned() {
        floor.insert_attribute(Mesh::ATTRIBUTE_UV_1, uvs);
    }
    let subject = s.mesh(
        floor,
        StandardMaterial {
            base_color: Color::srgb(0.6, 0.6, 0.55),
            lightmap_exposure: 4000.0,
            ..default()
        },
        Transform::default(),
    );
    s.mesh(
        Cuboid::new(3.0, 2.0, 0.3),
        Color::srgb(0.3, 0.4, 0.7),
        Transform::from_xyz(0.0, 1.0, -0.5),
    );
    s.sun(true);
    // Sees the lamp's layer too.
    s.camera(
        default_camera_transform(),
        RenderLayers::from_layers(&[0, 1]),
    );
    let lightmap = s.image(4, TextureFormat::Rgba8UnormSrgb, |_, _| [40, 220, 90, 255]);
    s.world().insert_resource(Lamps { lightmap });
    s.world().insert_resource(Subject(subject));
    s.world().init_resource::<Next>();
    s.headless.app.add_systems(Update, act);
}

/// A red lamp on layer 1.
fn layered_lamp(s: &mut SceneBuilder) {
    s.spawn((
        PointLight {
            intensity: 900_000.0,
            color: Color::srgb(1.0, 0.1, 0.1),
            ..default()
        },
        RenderLayers::layer(1),
        Transform::from_xyz(1.5, 1.0, 1.5),
    ));
}

type Extra = fn(&mut SceneBuilder);
const NOTHING: Extra = |_| {};

fn stage(extra: Extra, first: Change) -> Headless {
    let mut headless = build(SIZE, |s| {
        scene(s);
        extra(s);
    });
    set_lean(&mut headless, true);
    headless.world().insert_resource(Next(Some(first)));
    headless.settle();
    headless.frames(2);
    assert_eq!(active_lean_views(&mut headless), 1);
    headless
}

/// The picture of a mesh that had this state from the start.
fn at_rest(extra: Extra, state: Change) -> Picture {
    stage(extra, state).capture()
}

/// A state of the mesh, and the picture of a mesh that had it from the start.
type State<'a> = (Change, &'a Picture);

/// Changes the mesh twice, the second time with all shaders compiled. Frames of the first time are not compared with a lamp on layers:
/// forward draws the mesh in between, and ignores light layers.
fn assert_fresh(name: &str, extra: Extra, (from, before): State, (to, after): State) {
    let has_layers = core::ptr::fn_addr_eq(extra, layered_lamp as Extra);
    let apart = pixel_difference(before, after);
    assert!(apart.psnr < 38.0, "{name}: nothing to tell apart, {apart}");
    let mut headless = stage(extra, from);
    for time in ["first", "second"] {
        let film = headless.film(FRAMES, |world, frame| {
            if frame == BEFORE {
                world.insert_resource(Next(Some(to)));
            }
        });
        for (frame, picture) in film.iter().enumerate() {
            if time == "first" && has_layers {
                continue;
            }
            let expected = if frame < BEFORE { before } else { after };
            let difference = pixel_difference(expected, picture);
            let message = format!("{name}, {time} time, frame {frame}: {difference}");
            assert!(difference.psnr > 45.0, "{message}");
        }
        headless.world().insert_resource(Next(Some(from)));
        headless.settle();
        headless.frames(2);
    }
    log_watch::assert_validation_layer_silent();
    let errors = log_watch::messages_with("rror");
    assert!(errors.is_empty(), "{errors:?}");
}

const AS_IT_IS: Change = |_, _| {};

const LIGHTMAPPED: Change = |mesh, lamps| {
    mesh.insert(Lightmap {
        image: lamps.lightmap.clone(),
        ..default()
    });
};
const NOT_LIGHTMAPPED: Change = |mesh, _| {
    mesh.remove::<Lightmap>();
};

#[test]
#[ignore = "nightly: as `changes_in_every_frame`"]
fn lightmap() {
    in_own_process(|| {
        let states = [NOT_LIGHTMAPPED, LIGHTMAPPED];
        let [plain, lightmapped] = states.map(|state| at_rest(NOTHING, state));
        let without = (NOT_LIGHTMAPPED, &plain);
        let with = (LIGHTMAPPED, &lightmapped);
        assert_fresh("lightmap added", NOTHING, without, with);
        assert_fresh("lightmap removed", NOTHING, with, without);
    });
}

#[test]
#[ignore = "nightly: as `parity::changes`, frame by frame"]
fn shadow_receiver() {
    in_own_process(|| {
        const NONE: Change = |mesh, _| {
            mesh.insert(NotShadowReceiver);
        };
        const AGAIN: Change = |mesh, _| {
            mesh.remove::<NotShadowReceiver>();
        };
        let [shaded, unshaded] = [AGAIN, NONE].map(|state| at_rest(NOTHING, state));
        let (with, without) = ((AGAIN, &shaded), (NONE, &unshaded));
        assert_fresh("no shadows", NOTHING, with, without);
        assert_fresh("shadows again", NOTHING, without, with);
    });
}

#[test]
#[ignore = "nightly: `light_layers::existence` changes them too"]
fn render_layers() {
    in_own_process(|| {
        const LIT: Change = |mesh, _| {
            mesh.insert(RenderLayers::from_layers(&[0, 1]));
        };
        const UNLIT: Change = |mesh, _| {
            mesh.remove::<RenderLayers>();
        };
        const OTHER: Change = |mesh, _| {
            mesh.insert(RenderLayers::layer(1));
        };
        let pictures = [UNLIT, LIT, OTHER].map(|state| at_rest(layered_lamp, state));
        let [unlit, lit, other] = pictures.each_ref();
        let (unlit, lit, other) = ((UNLIT, unlit), (LIT, lit), (OTHER, other));
        assert_fresh("layers added", layered_lamp, unlit, lit);
        assert_fresh("layers changed", layered_lamp, other, unlit);
        assert_fresh("layers removed", layered_lamp, lit, unlit);
    });
}

/// A lightmap may be added and removed in alternating frames.
#[test]
fn changes_in_every_frame() {
    in_own_process(|| {
        let mut headless = stage(NOTHING, AS_IT_IS);
        let changes = [LIGHTMAPPED, NOT_LIGHTMAPPED];
        let [plain, lightmapped] = [AS_IT_IS, LIGHTMAPPED].map(|state| at_rest(NOTHING, state));
        let film = headless.film(8, |world, frame| {
            world.insert_resource(Next(Some(changes[frame % 2])));
        });
        for (frame, picture) in film.iter().enumerate() {
            let expected = [&lightmapped, &plain][frame % 2];
            let difference = pixel_difference(expected, picture);
            assert!(difference.psnr > 45.0, "frame {frame}: {difference}");
        }
        log_watch::assert_validation_layer_silent();
    });
}

/// The camera, too, may lose and regain the component by commands in every frame.
#[test]
fn cameras_switched_in_every_frame() {
    in_own_process(|| {
        let mut headless = stage(NOTHING, AS_IT_IS);
        headless.app.add_systems(
            Update,
            |mut commands: Commands,
             cameras: Query<(Entity, Has<LeanDeferred>), With<Camera3d>>| {
                for (camera, is_lean) in &cameras {
                    if is_lean {
                        commands.entity(camera).remove::<LeanDeferred>();
                    } else {
                        commands.entity(camera).insert(LeanDeferred::default());
                    }
                }
            },
        );
        let film = headless.film(8, |_, _| {});
        for (frame, picture) in film.iter().enumerate().skip(1) {
            let difference = pixel_difference(&film[0], picture);
            assert!(difference.psnr > 45.0, "frame {frame}: {difference}");
        }
        log_watch::assert_validation_layer_silent();
    });
}

/// Layers given to pooled meshes and lights while they are disabled apply once they are enabled. (Bevy never shows what was spawned
/// disabled, and misses a `NotShadowReceiver` added meanwhile.)
#[test]
#[ignore = "nightly: combines layers and disabled entities"]
fn layers_change_while_things_are_disabled() {
    in_own_process(|| {
        let picture = |disabled: bool| {
            let mut pool = Vec::new();
            let mut headless = build(SIZE, |s| {
                scene(s);
                let place = Transform::from_xyz(-1.5, 0.5, 1.5);
                let ball = s.mesh(Sphere::new(0.5), Color::WHITE, place);
                let light = PointLight {
                    intensity: 200_000.0,
                    ..default()
                };
                let lamp = s.spawn((light, Transform::from_xyz(0.0, 1.5, 2.0)));
                pool.extend([ball, lamp]);
            });
            set_lean(&mut headless, true);
            headless.settle();
            for &entity in pool.iter().filter(|_| disabled) {
                headless.world().entity_mut(entity).insert(Disabled);
            }
            headless.frames(BEFORE);
            let layer = RenderLayers::layer(1);
            for &entity in &pool {
                headless.world().entity_mut(entity).insert(layer.clone());
            }
            headless.frames(BEFORE);
            for &entity in &pool {
                headless.world().entity_mut(entity).remove::<Disabled>();
            }
            headless.settle();
            headless.frames(BEFORE);
            assert_eq!(active_lean_views(&mut headless), 1);
            headless.capture()
        };
        let difference = pixel_difference(&picture(false), &picture(true));
        println!("{difference}");
        assert_eq!(difference.largest, 0);
    });
}

/// While no camera is lean nothing is tracked: changes made then are known once one is. `before` is the picture without changes.
fn assert_known_later(name: &str, extra: Extra, before: &Picture, changes: [Change; 2]) {
    let picture = |is_lean_meanwhile: bool| {
        let mut headless = build(SIZE, |s| {
            scene(s);
            extra(s);
        });
        for change in changes {
            set_lean(&mut headless, is_lean_meanwhile);
            headless.settle();
            headless.world().insert_resource(Next(Some(change)));
            headless.frames(BEFORE);
            set_lean(&mut headless, true);
            headless.settle();
            headless.frames(BEFORE);
        }
        assert_eq!(active_lean_views(&mut headless), 1);
        headless.capture()
    };
    let [followed, found] = [true, false].map(picture);
    let difference = pixel_difference(&followed, &found);
    println!("{name}: {difference}");
    assert_eq!(difference.largest, 0, "{name}: {difference}");
    let is_changed = pixel_difference(before, &found).psnr < 38.0;
    assert_eq!(is_changed, !name.ends_with("back"), "{name}");
    log_watch::assert_validation_layer_silent();
}

#[test]
#[ignore = "nightly: as `apps::plugins::unused`, for further components"]
fn what_changes_while_no_camera_is_lean() {
    in_own_process(|| {
        const NO_SHADOWS: Change = |mesh, _| {
            mesh.insert(NotShadowReceiver);
        };
        const SHADOWS: Change = |mesh, _| {
            mesh.remove::<NotShadowReceiver>();
        };
        const LIT: Change = |mesh, _| {
            mesh.insert(RenderLayers::from_layers(&[0, 1]));
        };
        const UNLIT: Change = |mesh, _| {
            mesh.remove::<RenderLayers>();
        };
        let before = &at_rest(NOTHING, AS_IT_IS);
        let check = |name, changes| assert_known_later(name, NOTHING, before, changes);
        check("receiver", [AS_IT_IS, NO_SHADOWS]);
        check("receiver and back", [NO_SHADOWS, SHADOWS]);
        check("lightmap", [AS_IT_IS, LIGHTMAPPED]);
        check("lightmap and back", [LIGHTMAPPED, NOT_LIGHTMAPPED]);
        let before = &at_rest(layered_lamp, AS_IT_IS);
        let check = |name, changes| assert_known_later(name, layered_lamp, before, changes);
        check("layers", [AS_IT_IS, LIT]);
        check("layers and back", [LIT, UNLIT]);
    });
}
